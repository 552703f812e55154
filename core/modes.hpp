#pragma once

#include <Eigen/Core>

#include "core/linearisation.hpp"

namespace stillframe {

/// Modes of a linear model at rest. Natural frequencies and shapes solve (K + G) v = omega^2 M v,
/// sorted upwards, shapes mass-normalised (V^T M V = I). eigenvalues are those of the state matrix
/// A (2 n_d), damping included, sorted by modulus, a pair with its positive imaginary part first;
/// damping_ratios belong to them in that order, one a mode.
struct Modes {
  Eigen::VectorXd natural_frequencies_hz;  ///< n_d
  Eigen::VectorXd damping_ratios;          ///< n_d, 1
  Eigen::MatrixXd shapes;                  ///< n_d x n_d
  Eigen::VectorXcd eigenvalues;            ///< 2 n_d, rad/s
};

/// Errors: Refusal if M is not positive definite or a square of a natural frequency is negative
/// (unstable).
Modes modes(const LinearModel& model);

}  // namespace stillframe
