#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/numerics/singular_values.hpp"

namespace stillframe {

/// G(s), outputs from inputs (n_y x n_u), of a linear model at a complex frequency s, rad/s.
/// Position, velocity and acceleration of a prescribed motion enter as (1, s, s^2), (1/s, 1, s) or
/// (1/s^2, 1/s, 1) by the input's quantity. Evaluated on the second-order form: one n_d x n_d
/// solve. Source: deck, section 10, cases 1 to 3.
Eigen::MatrixXcd transfer_function(const LinearModel& model, std::complex<double> s);

/// The position of a prescribed motion whose own quantity is 1: 1, 1/s or 1/s^2; 1 for what is no
/// motion.
std::complex<double> position_of(Quantity quantity, std::complex<double> s);

/// T = G_11 + G_12 C (I - G_22 C)^-1 G_21 with G partitioned after n_w inputs and n_y outputs, and
/// the feedback u = C y_sigma (m x m). Source: deck, section 11.2.
Eigen::MatrixXcd closed_loop(const Eigen::MatrixXcd& G, Eigen::Index n_w, Eigen::Index n_y,
                             const Eigen::MatrixXcd& C);

/// n frequencies evenly spaced on a logarithmic axis, both ends included, Hz.
Eigen::VectorXd logarithmic_frequencies(double from_hz, double to_hz, Eigen::Index n);

}  // namespace stillframe
