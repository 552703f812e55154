#pragma once

#include <Eigen/Core>

namespace stillframe {

/// Singular values of an upper bidiagonal matrix, each to high relative accuracy, by the
/// differential qd algorithm with shifts. q: squares of the n diagonal entries, e: squares of the
/// n - 1 entries beside it, of size about 1 or below, both overwritten; `taken` has been taken away
/// from all squared values before; work: 3 n; values: n, in no order. Squares below 1e-290 count as
/// zero. Hot: noexcept, no allocation. Source: Fernando and Parlett, Numerische Mathematik 67
/// (1994) 191-229; splitting and mended shifts after Parlett and Marques, Linear Algebra and its
/// Applications 309 (2000) 217-259.
void qd_values(double* q, double* e, Eigen::Index n, double taken, double* work,
               double* values) noexcept;

}  // namespace stillframe
