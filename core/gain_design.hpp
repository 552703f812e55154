#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/scene/scene.hpp"

namespace stillframe {

/// Mass and stiffness as the legs feel them, m x m: M in kg, K in N/m.
struct LegMatrices {
  Eigen::MatrixXd M, K;
};

/// Turns M_dd and K_dd into leg coordinates, so that the gains do not depend on the choice of q^d:
///   M = E^-T M_dd E^-1, K = E^-T K_dd E^-1, E = D_dF^(e) of the legs (m x n_d).
/// Errors: Refusal if the legs are not as many as the dofs or do not determine them.
LegMatrices leg_matrices(const Eigen::MatrixXd& M_dd, const Eigen::MatrixXd& K_dd,
                         const Eigen::MatrixXd& E);

/// C(s) = -(K_P s + K_I) / (s + omega_l), u = sigma_a, y = sigma; omega_l = 0 is the deck's PI.
struct ForceFeedback {
  Eigen::MatrixXd K_P, K_I;  ///< m x m: 1 and 1/s
  double leak = 0;           ///< omega_l, rad/s

  Eigen::MatrixXcd operator()(std::complex<double> s) const;
};

/// X = I + K_P = K M^-1 / omega_d^2 (exact) or M^-1 K / omega_d^2 (deck), K_I = 2 zeta omega_d X.
/// Only the exact order puts all poles of every pair (M, K) on s^2 + 2 zeta omega_d s + omega_d^2.
/// omega_d in rad/s. Source: deck, section 11.2; THEORY section 4, fact 1.
ForceFeedback design_gains(const LegMatrices& legs, double omega_d, double zeta, GainOrder order,
                           double leak);

/// The 3 m poles of the continuous closed loop: 2 m of the frame on its legs and m of the law;
/// without a leak the latter are zero, as a pure integrator cancels the static spring (THEORY
/// section 4, fact 2). Computed from
///   q'' = -M^-1 (K q + sigma_a),  X sigma_a' = -(omega_l + K_I) sigma_a - K_P K q' - K_I K q
/// in the state (K q, K q' / omega_scale, sigma_a), all in N, so that no entry is far larger than a
/// frequency.
Eigen::VectorXcd closed_loop_poles(const LegMatrices& legs, const ForceFeedback& gains,
                                   double omega_scale);

}  // namespace stillframe
