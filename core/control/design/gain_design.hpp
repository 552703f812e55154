#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/control/design/design_model.hpp"
#include "core/control/force_feedback.hpp"
#include "core/mechanics/scene/scene.hpp"
#include "core/numerics/extended/double_double.hpp"

namespace stillframe {

/// What a virtual mode is to become: s^2 + 2 zeta omega_d s + omega_d^2 = 0.
struct ModeTarget {
  double omega_d = 0, zeta = 0;  ///< rad/s, 1
};

/// The modes of the virtual legs, slowest first, in twice the working precision:
///   K Phi = M Phi diag(squares),  Phi^T M Phi = I.
struct VirtualModes {
  ExtendedVector squares;  ///< r, omega^2, 1/s^2
  ExtendedMatrix Phi;      ///< r x r
};

/// Errors: as extended_gains.
VirtualModes virtual_modes(const LegMatrices& legs, const std::vector<ModeTarget>& targets);

/// A gain design as it is computed, in twice the working precision: X = I + K_P and K_I, r x r,
/// 1 and 1/s.
///
/// Rounding X to doubles moves the poles by up to about eps cond(M) cond(K), however well X was
/// computed; in this form they stay on their targets for conditions of 1e8 each. It serves to tell
/// what the design does from what rounding does. A control law has no use for it: M and K that are
/// known to eps of their largest entries move the poles by eps (cond(M) + cond(K)) anyhow. What
/// separates the two, where both matrices are ill conditioned, is the product in place of the sum.
struct GainDesign {
  ExtendedMatrix X, K_I;

  /// The gains of the r virtual legs, each entry rounded once; no leak, high-pass or roll-off.
  ForceFeedback gains() const;
};

/// Gains in the virtual legs of a design model. With the modes K Phi = M Phi Omega^2,
/// Phi^T M Phi = I, slowest first, and the targets of each:
///   X = K Phi diag(1 / omega_d^2) Phi^T,  K_I = K Phi diag(2 zeta / omega_d) Phi^T  (exact),
///   X and K_I the transposes of these (deck).
/// With one target for all, X = K M^-1 / omega_d^2 or M^-1 K / omega_d^2, K_I = 2 zeta omega_d X,
/// and no mode is needed. Only the exact order gives every pair (M, K) its targets.
/// targets: one, or r. Errors: Refusal if M or K is not positive definite, or if modes of the same
/// frequency (to 1e-6) have different targets, as their shapes are not determined;
/// std::invalid_argument on the number of targets or one that is not above zero. Source: deck,
/// section 11.2; THEORY section 4, fact 1.
GainDesign extended_gains(const LegMatrices& legs, const std::vector<ModeTarget>& targets,
                          GainOrder order);

/// The gains of the m legs, m x m, K_P = Q (X - I) Q^T and Q K_I Q^T of extended_gains, rounded
/// once; leak, high-pass and roll-off are left zero. Errors as extended_gains.
ForceFeedback design_gains(const DesignModel& model, const std::vector<ModeTarget>& targets,
                           GainOrder order);

/// The same for m legs on m dofs with one target. omega_d, leak in rad/s.
ForceFeedback design_gains(const LegMatrices& legs, double omega_d, double zeta, GainOrder order,
                           double leak);

/// Natural frequencies of the r virtual modes, rad/s, slowest first. Errors: Refusal if M or K is
/// not positive definite.
Eigen::VectorXd virtual_frequencies(const LegMatrices& legs);

/// The poles of the continuous closed loop, smallest modulus first: 2 r of the frame on its legs
/// and r each of the law, of a high-pass beside a leak, and of a roll-off. Without a leak those of
/// the law are zero, exactly, as a pure integrator cancels the static spring (THEORY section 4,
/// fact 2). Computed in twice the working precision and rounded, so that their error is that of the
/// gains. omega_scale: rad/s, about where the poles are, to scale the states with. With L L^T = M
/// they are the eigenvalues of
///   q'' = -M^-1 (sigma_0 + d),    sigma_0 = K q - w,  d = w - roll-off of w,
///   X sigma_0' = K q' + omega_l K q - (omega_l + K_I) sigma_0 + K_P g' + K_I g,
///   g' = omega_h (sigma_0 - g),   d' = (1 - tau omega_r) (K q' - sigma_0') - omega_r d
/// in the states L^T q', L^-1 sigma_0, L^-1 d, L^-1 g, L^T q. Errors: Refusal if M is not positive
/// definite or X is singular.
Eigen::VectorXcd closed_loop_poles(const LegMatrices& legs, const ForceFeedback& gains,
                                   double omega_scale);
/// The same of a design before rounding, without leak, high-pass and roll-off.
Eigen::VectorXcd closed_loop_poles(const LegMatrices& legs, const GainDesign& design,
                                   double omega_scale);

}  // namespace stillframe
