#pragma once

#include <Eigen/Core>

#include "core/control/force_feedback.hpp"
#include "core/systems/linear_system.hpp"
#include "core/systems/realisation.hpp"

namespace stillframe {

/// A sampled feedback law as plain matrices:
///   r[k] = a r[k-1] + (1 - a) sigma_a,applied[k],   e[k] = sigma[k] - (subtract_applied ? r[k] :
///   0), u[k] = C x[k] + D e[k],   x[k+1] = A x[k] + B e[k].
/// a = applied_memory is that of the low-pass that sigma comes through; 0: none. A: n x n, B: n x
/// m, C: m x n, D: m x m for m legs; u and e in N. Where B and D have 2 m columns the law hears the
/// applied force by itself, and e is (sigma, sigma_a,applied) instead. Linear, before any
/// saturation. What feed_forward (inputs: the first accelerations of the floor in the same
/// measurement, m/s^2) makes of the floor is added to u.
struct DiscreteLaw {
  Eigen::MatrixXd A, B, C, D;
  bool subtract_applied = true;
  double applied_memory = 0;
  LinearSystem feed_forward = {};  ///< without columns in D: none

  bool hears_applied() const { return D.cols() > D.rows(); }
};

/// What the sampling of a law needs beside the law.
struct LawSampling {
  Realisation realisation = Realisation::implicit_feedthrough;
  double sample_time = 0;       ///< s
  double lead_samples = 0;      ///< e is predicted so far ahead, >= 0
  double sensor_filter_hz = 0;  ///< corner of the low-pass before sigma is sampled; 0: none
};

/// The sampled form of a continuous law, by Tustin's rule s = (2/T)(z - 1)/(z + 1).
///   implicit_feedthrough: strain_feedback, on sigma less the applied force, which is first
///   filtered as the sensor filters sigma (exact for forces held over each sample); naive_pi:
///   stress_feedback on sigma; with lead_samples = a > 0, e[k] is first replaced by (1 + a) e[k] -
///   a e[k-1], which makes up for a force that acts a samples after its measurement (the delay, and
///   half a sample of hold). It stands for all of the lead: that of the continuous law is left out.
/// Source: THEORY section 4, fact 3. Set-up. Errors: as strain_feedback and tustin.
DiscreteLaw sample_law(ForceFeedback feedback, const LawSampling& sampling);

}  // namespace stillframe
