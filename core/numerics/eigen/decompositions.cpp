#include "core/numerics/eigen/once.hpp"

namespace Eigen {

template class PartialPivLU<MatrixXd>;
template class PartialPivLU<MatrixXcd>;
template class LLT<MatrixXd>;
template class HouseholderQR<MatrixXd>;
template class HouseholderQR<MatrixXcd>;
template class ColPivHouseholderQR<MatrixXd>;
template class ColPivHouseholderQR<MatrixXcd>;

}  // namespace Eigen
