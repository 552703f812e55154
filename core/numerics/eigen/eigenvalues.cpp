#include "core/numerics/eigen/once.hpp"

namespace Eigen {

template class HessenbergDecomposition<MatrixXd>;
template class HessenbergDecomposition<MatrixXcd>;
template class RealSchur<MatrixXd>;
template class ComplexSchur<MatrixXcd>;
template class EigenSolver<MatrixXd>;
template class ComplexEigenSolver<MatrixXcd>;
template class Tridiagonalization<MatrixXd>;
template class SelfAdjointEigenSolver<MatrixXd>;
template class SelfAdjointEigenSolver<MatrixXcd>;

}  // namespace Eigen
