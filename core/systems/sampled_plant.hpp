#pragma once

#include <Eigen/Core>

#include "core/systems/instruments.hpp"

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

/// How a plant is sampled and commanded.
struct Sampling {
  double sample_time = 0;    ///< s
  double delay_samples = 0;  ///< a command from sample k takes effect so many samples after t_k
  Instruments instruments;
  /// m, force that acts over force that is reported of each leg, times instruments.actuator_gain;
  /// empty: all 1.
  Eigen::VectorXd leg_gains;
  Eigen::VectorXd leg_delays;    ///< m, samples, each >= 0, beside delay_samples; empty: all 0
  Eigen::VectorXd sensor_gains;  ///< m, what each force sensor reads over sigma; empty: all 1
};

/// LoopPlant with its instruments, x = (force of the actuators, filtered sigma, z) as far as they
/// are there; w held over each sample. u[k] is the command of sample k and d = n + phi its delay
/// (each leg may have its own), so that c_0 = u[k-n-1] acts in [t_k, t_k + phi T_s) and c_1 =
/// u[k-n] from there to t_{k+1}:
///   x[k+1] = Phi x[k] + Gamma_w w[k] + Gamma_0 c_0 + Gamma_u c_1,
///   y[k+1] = C_y x[k] + D_yw w[k] + D_0 c_0 + D_yu c_1  (mean of y over [t_k, t_{k+1}]),
///   sigma[k] = C_sigma x[k] + D_sigma c_0,   report[k] = C_report x[k] + D_report c_0  (at t_k).
/// The outputs are read as means by an integrating instrument (for an acceleration the change of
/// velocity over T_s). Point readings of y would fold the ripple of the held forces into it, which
/// for a force that cancels a stiff spring is larger than the motion itself.
struct SampledPlant {
  Eigen::MatrixXd Phi, Gamma_w, Gamma_0, Gamma_u;
  Eigen::MatrixXd C_y, D_yw, D_0, D_yu;
  Eigen::MatrixXd C_sigma, D_sigma, C_report, D_report;
  Eigen::Index n_exogenous = 0;  ///< trailing states that w alone drives
  Eigen::VectorXi whole_delay;   ///< n, m
  int report_age = 0;            ///< samples by which the law gets report[k] late
  double sample_time = 0;        ///< s
};

/// Exact discretisation by exponentials of the augmented matrix of (x, w, c, integral of y) over
/// the two parts of the sample. Source: THEORY section 5.
/// Errors: std::invalid_argument if sample_time is not positive, the delay is negative or not
/// finite, or leg_gains or sensor_gains are not m.
SampledPlant sample_and_hold(const LoopPlant& plant, const Sampling& sampling);

}  // namespace stillframe
