#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <complex>

// Eigen's decompositions and the inner loops of its products, compiled once (decompositions.cpp,
// eigenvalues.cpp, singular_values.cpp, products.cpp) instead of in every file that touches them,
// which then compile 1.4 to 3 times as fast. None of it is short enough to be inlined.
// Precompiled into every target (cmake/StillframeHeaders.cmake); no file includes it by name, and
// any file may be compiled without it.

// Kernels are no part of Eigen's interface: of another version only the decompositions are shared.
#if EIGEN_WORLD_VERSION == 3 && EIGEN_MAJOR_VERSION == 4
#define STILLFRAME_EIGEN_KERNELS
#endif

namespace Eigen {

extern template class PartialPivLU<MatrixXd>;
extern template class PartialPivLU<MatrixXcd>;
extern template class LLT<MatrixXd>;
extern template class HouseholderQR<MatrixXd>;
extern template class HouseholderQR<MatrixXcd>;
extern template class ColPivHouseholderQR<MatrixXd>;
extern template class ColPivHouseholderQR<MatrixXcd>;
extern template class HessenbergDecomposition<MatrixXd>;
extern template class HessenbergDecomposition<MatrixXcd>;
extern template class RealSchur<MatrixXd>;
extern template class ComplexSchur<MatrixXcd>;
extern template class EigenSolver<MatrixXd>;
extern template class ComplexEigenSolver<MatrixXcd>;
extern template class Tridiagonalization<MatrixXd>;
extern template class SelfAdjointEigenSolver<MatrixXd>;
extern template class SelfAdjointEigenSolver<MatrixXcd>;
extern template class JacobiSVD<MatrixXd>;
extern template class JacobiSVD<MatrixXcd>;
extern template class BDCSVD<MatrixXd>;

#ifdef STILLFRAME_EIGEN_KERNELS
namespace internal {

template <class Scalar, int order>
using OnceMapper = const_blas_data_mapper<Scalar, Index, order>;

extern template struct general_matrix_vector_product<Index, double, OnceMapper<double, 0>, 0, false,
                                                     double, OnceMapper<double, 0>, false, 0>;
extern template struct general_matrix_vector_product<Index, double, OnceMapper<double, 0>, 0, false,
                                                     double, OnceMapper<double, 1>, false, 0>;
extern template struct general_matrix_vector_product<Index, double, OnceMapper<double, 1>, 1, false,
                                                     double, OnceMapper<double, 0>, false, 0>;
extern template struct general_matrix_vector_product<Index, double, OnceMapper<double, 1>, 1, false,
                                                     double, OnceMapper<double, 1>, false, 0>;
extern template struct general_matrix_vector_product<
    Index, std::complex<double>, OnceMapper<std::complex<double>, 0>, 0, false,
    std::complex<double>, OnceMapper<std::complex<double>, 0>, false, 0>;
extern template struct general_matrix_vector_product<
    Index, std::complex<double>, OnceMapper<std::complex<double>, 1>, 1, false,
    std::complex<double>, OnceMapper<std::complex<double>, 0>, false, 0>;

template <class Scalar>
using OnceTraits = gebp_traits<Scalar, Scalar>;
extern template struct gebp_kernel<double, double, Index,
                                   blas_data_mapper<double, Index, ColMajor, Unaligned, 1>,
                                   OnceTraits<double>::mr, OnceTraits<double>::nr, false, false>;
extern template struct gebp_kernel<
    std::complex<double>, std::complex<double>, Index,
    blas_data_mapper<std::complex<double>, Index, ColMajor, Unaligned, 1>,
    OnceTraits<std::complex<double>>::mr, OnceTraits<std::complex<double>>::nr, false, false>;

}  // namespace internal
#endif

}  // namespace Eigen
