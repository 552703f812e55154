#pragma once

#include "core/mechanics/sparse/mixed_model.hpp"

namespace stillframe {

/// The lowest natural frequencies of (K + G) v = omega^2 M v without damping, and their shapes on
/// the free coordinates, mass-normalised.
struct LowestModes {
  Eigen::VectorXd natural_frequencies_hz;  ///< n_modes, upwards; 0 where nothing resists
  Eigen::MatrixXd shapes;                  ///< n_c x n_modes
  Eigen::VectorXd squares, known_to;       ///< n_modes, omega^2 and its rounding, (rad/s)^2
};

/// By shift-invert Lanczos on the mixed form, n_modes or as many as have mass. Errors: Refusal if
/// the matrix is singular (conditions that are not independent, or a motion without stiffness and
/// mass); Unstable if a square of a natural frequency is negative.
LowestModes lowest_modes(const MixedModel& mixed, const MixedState& state, Eigen::Index n_modes);

}  // namespace stillframe
