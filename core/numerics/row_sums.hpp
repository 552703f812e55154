#pragma once

#include <Eigen/Core>
#include <complex>

namespace stillframe {

/// Columns handled together by the two below: their sums stay in registers.
constexpr Eigen::Index row_chunk = 8;

/// out[0..width) += sum_j coefficients[j] rows[j width + 0..width); width a multiple of row_chunk.
/// Hot: noexcept, no allocation.
void add_combination(const double* coefficients, const double* rows, Eigen::Index count,
                     Eigen::Index width, double* out) noexcept;

/// Columns [0, used) of R = F - (s I - A) X, every sum in doubled precision. A: n x n; the others
/// are complex, re and im of an entry side by side, n rows of width; all of them by rows. width: a
/// multiple of row_chunk. Hot: noexcept, no allocation.
void doubled_residual(std::complex<double> s, Eigen::Index n, Eigen::Index width, Eigen::Index used,
                      const double* A, const double* X, const double* F, double* R) noexcept;

}  // namespace stillframe
