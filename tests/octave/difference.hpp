#pragma once

#include <Eigen/Core>

namespace stillframe::octave {

/// Values below this part of the largest beside them are compared with that part of it instead of
/// with themselves: what comes out of sums and eigenvalues with the largest is good to rounding of
/// that.
inline constexpr double small_part = 1e-3;

/// Largest |a_i - b_i| over largest |b_i|; infinite if shapes differ or an entry is not finite, 0
/// if both are empty.
double matrix_difference(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);

/// The worst matrix_difference of the columns.
double column_difference(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);

/// Largest |a_ij - b_ij| over |b_ij|, or over small_part of the largest in its column if that is
/// more; as above.
double value_difference(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);

/// The same of two sets in any order: each b, largest first, with the nearest a that is left. What
/// is zero but for the square root of rounding in both counts as equal: so far apart do the double
/// poles at zero of a body that floats come out (their squares are off by rounding of the largest).
/// part: in place of small_part; 1 for poles in the unit circle, where nearness to it counts.
double pole_difference(const Eigen::VectorXcd& a, const Eigen::VectorXcd& b,
                       double part = small_part);

}  // namespace stillframe::octave
