#pragma once

#include <Eigen/Core>

#include "core/systems/multisine_plan.hpp"

namespace stillframe::floor {

/// The share of a transition that is done at tau (0 to 1): the integral of a four-term
/// Blackman-Harris window. What it excites more than 4 / ramp_s away from a line is some 100 dB
/// below that line. Source: F. J. Harris, Proc. IEEE 66 (1978) 51-83, for the window.
double glide(double tau);

/// The whole experiment, channels x samples, m/s^2. Errors: std::invalid_argument unless there are
/// lines, at least one block, and ramp and window are whole numbers of samples.
Eigen::MatrixXd multisine_table(const MultisinePlan& plan);

}  // namespace stillframe::floor
