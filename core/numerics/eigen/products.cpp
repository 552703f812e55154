#include "core/numerics/eigen/once.hpp"

#ifdef STILLFRAME_EIGEN_KERNELS
namespace Eigen::internal {

template struct general_matrix_vector_product<Index, double, OnceMapper<double, 0>, 0, false,
                                              double, OnceMapper<double, 0>, false, 0>;
template struct general_matrix_vector_product<Index, double, OnceMapper<double, 0>, 0, false,
                                              double, OnceMapper<double, 1>, false, 0>;
template struct general_matrix_vector_product<Index, double, OnceMapper<double, 1>, 1, false,
                                              double, OnceMapper<double, 0>, false, 0>;
template struct general_matrix_vector_product<Index, double, OnceMapper<double, 1>, 1, false,
                                              double, OnceMapper<double, 1>, false, 0>;
template struct general_matrix_vector_product<
    Index, std::complex<double>, OnceMapper<std::complex<double>, 0>, 0, false,
    std::complex<double>, OnceMapper<std::complex<double>, 0>, false, 0>;
template struct general_matrix_vector_product<
    Index, std::complex<double>, OnceMapper<std::complex<double>, 1>, 1, false,
    std::complex<double>, OnceMapper<std::complex<double>, 0>, false, 0>;
template struct gebp_kernel<double, double, Index,
                            blas_data_mapper<double, Index, ColMajor, Unaligned, 1>,
                            OnceTraits<double>::mr, OnceTraits<double>::nr, false, false>;
template struct gebp_kernel<std::complex<double>, std::complex<double>, Index,
                            blas_data_mapper<std::complex<double>, Index, ColMajor, Unaligned, 1>,
                            OnceTraits<std::complex<double>>::mr,
                            OnceTraits<std::complex<double>>::nr, false, false>;

}  // namespace Eigen::internal
#endif
