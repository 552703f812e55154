#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/linear/discrete_law.hpp"

namespace stillframe {

/// The continuous plant as the loop sees it, z its n states, w the p prescribed accelerations
/// (m/s^2), u the m actuator forces sigma_a (N), y the outputs that the loop is judged by:
///   dz/dt = A z + B_w w + B_u u,   y = C_y z + D_yw w + D_yu u,   sigma = C_sigma z + u.
/// The last n_exogenous states are integrals of w alone (velocity and position of the floor); they
/// are needed where floor motion strains elastic elements, and are no part of the feedback loop.
struct LoopPlant {
  Eigen::MatrixXd A, B_w, B_u, C_y, D_yw, D_yu, C_sigma;
  Eigen::Index n_exogenous = 0;
};

/// LoopPlant with w and u held over each sample. The outputs are read as their mean over the interval that has
/// just passed (an integrating instrument, for an acceleration the change of velocity over T_s):
///   z[k+1] = Phi z[k] + Gamma_w w[k] + Gamma_u u[k],
///   y[k+1] = C_y z[k] + D_yw w[k] + D_yu u[k]  (mean of y over [t_k, t_{k+1}]),
///   sigma[k] = C_sigma z[k] + u at t_k. Point readings of y would fold the ripple of the held forces into it, which
/// for a force that cancels a stiff spring is larger than the motion itself.
struct SampledPlant {
  Eigen::MatrixXd Phi, Gamma_w, Gamma_u, C_y, D_yw, D_yu, C_sigma;
  Eigen::Index n_exogenous = 0;
  double sample_time = 0;  ///< s
};

/// Plant and law as one linear discrete system in balanced states (of no unit of their own),
/// xi[k+1] = A xi[k] + B w[k], y[k+1] = C xi[k] + D w[k]. y[k+1] and the w[k] held up to it travel in the same
/// measurement; the transfer function between those two is C (z I - A)^-1 B + D.
struct SampledLoop {
  Eigen::MatrixXd A, B, C, D;
  Eigen::Index n_exogenous = 0;  ///< leading states that w alone drives
  double sample_time = 0;        ///< s
};

/// Exact zero-order-hold discretisation by the exponential of T_s times the augmented matrix of (z, w, u, integral
/// of y).
/// Errors: std::invalid_argument if sample_time is not positive.
SampledPlant sample_and_hold(const LoopPlant& plant, double sample_time);

/// The closed loop of a sampled plant and a law whose command from sample k takes effect at k +
/// delay. Source: THEORY section 5. Errors: std::invalid_argument on shapes that
/// do not match or a negative delay.
SampledLoop close_loop(const SampledPlant& plant, const DiscreteLaw& law, int delay_samples);

/// The same system without feedback (zero commands), for the passive prediction.
SampledLoop open_loop(const SampledPlant& plant);

/// Largest modulus of the eigenvalues of the feedback part of A (floor integrators left out).
double spectral_radius(const SampledLoop& loop);

/// T(e^{j omega T_s}), y from w: n_y x p. omega in rad/s.
Eigen::MatrixXcd transfer(const SampledLoop& loop, double omega);

}  // namespace stillframe
