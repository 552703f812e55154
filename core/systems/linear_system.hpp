#pragma once

#include <Eigen/Core>

namespace stillframe {

/// A linear system as plain matrices, dx/dt or x[k+1] = A x + B e, u = C x + D e; n states, m
/// inputs, p outputs. A: n x n, B: n x m, C: p x n, D: p x m.
struct LinearSystem {
  Eigen::MatrixXd A, B, C, D;
};

/// The system `second` fed by the output of `first`. Set-up.
/// Errors: std::invalid_argument if the sizes do not match.
LinearSystem in_series(const LinearSystem& first, const LinearSystem& second);

/// Samples a continuous system by Tustin's rule (trapezoidal), T in s:
///   with L = (I - T/2 A)^-1: A_d = L (I + T/2 A), B_d = L B, C_d = T C L, D_d = D + T/2 C L B.
/// The result has the frequency response of the continuous system at s = (2/T)(z - 1)/(z + 1).
/// Set-up. Errors: std::invalid_argument if T is not positive.
LinearSystem tustin(const LinearSystem& continuous, double sample_time);

}  // namespace stillframe
