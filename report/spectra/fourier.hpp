#pragma once

#include <Eigen/Core>

namespace stillframe::report {

/// The discrete Fourier transform of every column, X(k) = sum_i x_i e^{-2 pi j i k / n}, for
/// k = 0 .. n / 2: (n / 2 + 1) x columns. Columns of any length; those without large prime factors
/// are fast.
Eigen::MatrixXcd fourier(const Eigen::Ref<const Eigen::MatrixXd>& columns);

/// The largest number up to n without a prime factor above 5.
Eigen::Index fast_length(Eigen::Index n);

}  // namespace stillframe::report
