#pragma once

#include <Eigen/Core>

#include "core/mechanics/linearisation/linearisation.hpp"

namespace stillframe {

/// How far a reduced model is from the whole one, at a frequency, without a response of the whole
/// one. Residual forces R of the inputs and R_l of the outputs have no part on the modes and
/// corrections V, and the difference is R_l^T H^-1 R, H = K + j w D - w^2 M where the kept modes
/// V_m have no part. There, in the norm of K_s = K + shift M, and with w_c the lowest frequency
/// that was left out, the undamped H is between alpha_0 and 1 and the whole one at least alpha:
///   alpha_0 = (w_c^2 - w^2) / (w_c^2 + shift),   alpha = alpha_0 - delta,
/// where delta is what dampers carry there and back through the kept modes,
/// w^2 |S^1/2 (V_m^T H V_m)^-1 S^1/2|, S = V_m^T D K_s^-1 D V_m. With mu the largest D over K_s,
///   sigma_1(G - G_V) <= |R_l| |R| / alpha, and
///   sigma_1(G - G_V) <= (1 + 1 / alpha_0) / 2 sigma_1(R_l^T K_s^-1 R)
///     + ((1 / alpha_0 - 1) / 2 + (w mu + delta) / (alpha_0 alpha)) |R_l| |R|,
/// norms in K_s^-1. R and R_l are combinations of the same few columns W, whose coefficients at a
/// frequency are small matrices. G_V is on the modes and corrections as they are; what a model
/// without their smallest masses differs from it is computed. What rounding makes of the squares
/// of the kept modes, by which slow ones answer far below what resists, is added. Source:
/// docs/decisions/0036-reduced-models.md.
struct ReductionBound {
  /// W^T K_s^-1 W where the kept modes have no part. Columns of W, n_c each: forces of the inputs
  /// (F, and of w'', w' and w), M V, D V, K_s V, and rows of the outputs (of x, x' and x'').
  Eigen::MatrixXd gram;
  double rounding = 0;  ///< of its entries, over the lengths of both columns
  Eigen::Index n_modes = 0;
  double shift = 0;           ///< (rad/s)^2
  Eigen::VectorXd known_to;   ///< n_modes, what the squares of the kept modes are, (rad/s)^2
  double first_left_out = 0;  ///< w_c, rad/s; infinite if nothing with mass was left out
  double damping = 0;         ///< mu, s
  LinearModel projected;      ///< on modes and corrections as they are: G_V

  /// sigma_1(G - G_r) at w (rad/s), of the first n_in inputs to the first n_out outputs of a model
  /// G_r, is not above it; infinite at and above w_c.
  double operator()(double omega, const LinearModel& reduced, Eigen::Index n_in,
                    Eigen::Index n_out) const;
};

}  // namespace stillframe
