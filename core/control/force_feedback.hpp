#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/systems/linear_system.hpp"

namespace stillframe {

/// Force feedback of m legs, u = C(s) sigma, u = sigma_a. With
///   P(s) = (K_P s + K_I) / (s + omega_l) * s / (s + omega_h)
/// and no roll-off, C = -P; omega_l = omega_h = 0 is the deck's PI, and a high-pass alone is the
/// same law as a leak of its frequency. A roll-off omega_r acts on the force that the law adds to
/// what it takes out of the sensor, and a lead tau beside it: F = -(I + P)^-1 P (1 + tau s) omega_r
/// / (s + omega_r), C = (I + F)^-1 F.
/// Source: deck, section 11.2; THEORY section 4.
struct ForceFeedback {
  Eigen::MatrixXd K_P, K_I;  ///< m x m: 1 and 1/s
  double leak = 0;           ///< omega_l, rad/s
  double high_pass = 0;      ///< omega_h, rad/s
  double roll_off = 0;       ///< omega_r, rad/s; 0: none
  double lead = 0;           ///< tau, s, of the continuous law with a roll-off; nothing without one

  /// C(s), m x m, s in rad/s.
  Eigen::MatrixXcd operator()(std::complex<double> s) const;
};

/// The same law on the strain force sigma_p = sigma - sigma_a of the legs, that is with the
/// feedthrough of the force sensor solved for: F(s) = -(I + P)^-1 P, then the roll-off,
///   (I + P)^-1 P = (X s^2 + W s + omega_l omega_h I)^-1 (K_P s + K_I) s,
///   X = I + K_P, W = (omega_l + omega_h) I + K_I.
/// Of m states, 2 m with leak and high-pass, m more with a roll-off. Source: THEORY section 4, fact
/// 3. Errors: Refusal if X is singular, std::invalid_argument on gains that are not m x m.
LinearSystem strain_feedback(const ForceFeedback& feedback);

/// -P(s) on sigma itself, without the roll-off applied to the feedthrough: the naive reading of the
/// same gains. Errors: std::invalid_argument on gains that are not m x m.
LinearSystem stress_feedback(const ForceFeedback& feedback);

}  // namespace stillframe
