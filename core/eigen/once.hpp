#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <complex>

// Eigen's decompositions and the inner loops of its products, compiled once (once.cpp) instead of
// in every file that touches them, which halves the time of a build. Nothing of it is inlined
// anyway, so programs are as fast. Precompiled into every target (cmake/StillframeHeaders.cmake);
// no file includes it by name, and any file may be compiled without it.

#ifndef STILLFRAME_EIGEN_ONCE
#define STILLFRAME_EIGEN_ONCE extern
#endif

// Kernels are no part of Eigen's interface: of another version only the decompositions are shared.
#if EIGEN_WORLD_VERSION == 3 && EIGEN_MAJOR_VERSION == 4
#define STILLFRAME_EIGEN_KERNELS
#endif

namespace Eigen {

STILLFRAME_EIGEN_ONCE template class PartialPivLU<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class PartialPivLU<MatrixXcd>;
STILLFRAME_EIGEN_ONCE template class FullPivLU<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class LLT<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class LDLT<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class HouseholderQR<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class HouseholderQR<MatrixXcd>;
STILLFRAME_EIGEN_ONCE template class ColPivHouseholderQR<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class ColPivHouseholderQR<MatrixXcd>;
STILLFRAME_EIGEN_ONCE template class CompleteOrthogonalDecomposition<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class HessenbergDecomposition<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class HessenbergDecomposition<MatrixXcd>;
STILLFRAME_EIGEN_ONCE template class RealSchur<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class ComplexSchur<MatrixXcd>;
STILLFRAME_EIGEN_ONCE template class EigenSolver<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class ComplexEigenSolver<MatrixXcd>;
STILLFRAME_EIGEN_ONCE template class Tridiagonalization<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class SelfAdjointEigenSolver<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class SelfAdjointEigenSolver<MatrixXcd>;
STILLFRAME_EIGEN_ONCE template class JacobiSVD<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class JacobiSVD<MatrixXcd>;
STILLFRAME_EIGEN_ONCE template class BDCSVD<MatrixXd>;
STILLFRAME_EIGEN_ONCE template class BDCSVD<MatrixXcd>;

#ifdef STILLFRAME_EIGEN_KERNELS
namespace internal {

template <class Scalar, int order>
using OnceMapper = const_blas_data_mapper<Scalar, Index, order>;

STILLFRAME_EIGEN_ONCE template struct general_matrix_vector_product<
    Index, double, OnceMapper<double, 0>, 0, false, double, OnceMapper<double, 0>, false, 0>;
STILLFRAME_EIGEN_ONCE template struct general_matrix_vector_product<
    Index, double, OnceMapper<double, 0>, 0, false, double, OnceMapper<double, 1>, false, 0>;
STILLFRAME_EIGEN_ONCE template struct general_matrix_vector_product<
    Index, double, OnceMapper<double, 1>, 1, false, double, OnceMapper<double, 0>, false, 0>;
STILLFRAME_EIGEN_ONCE template struct general_matrix_vector_product<
    Index, double, OnceMapper<double, 1>, 1, false, double, OnceMapper<double, 1>, false, 0>;
STILLFRAME_EIGEN_ONCE template struct general_matrix_vector_product<
    Index, std::complex<double>, OnceMapper<std::complex<double>, 0>, 0, false,
    std::complex<double>, OnceMapper<std::complex<double>, 0>, false, 0>;
STILLFRAME_EIGEN_ONCE template struct general_matrix_vector_product<
    Index, std::complex<double>, OnceMapper<std::complex<double>, 1>, 1, false,
    std::complex<double>, OnceMapper<std::complex<double>, 0>, false, 0>;

template <class Scalar>
using OnceTraits = gebp_traits<Scalar, Scalar>;
STILLFRAME_EIGEN_ONCE template struct gebp_kernel<
    double, double, Index, blas_data_mapper<double, Index, ColMajor, Unaligned, 1>,
    OnceTraits<double>::mr, OnceTraits<double>::nr, false, false>;
STILLFRAME_EIGEN_ONCE template struct gebp_kernel<
    std::complex<double>, std::complex<double>, Index,
    blas_data_mapper<std::complex<double>, Index, ColMajor, Unaligned, 1>,
    OnceTraits<std::complex<double>>::mr, OnceTraits<std::complex<double>>::nr, false, false>;

}  // namespace internal
#endif

}  // namespace Eigen
