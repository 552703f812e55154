#pragma once

#include <Eigen/Core>

namespace stillframe::floor {

/// A smooth step of position, s(p) = p^3 (10 - 15 p + 6 p^2): stays where it went.
struct StepCourse {
  double height = 0.0;  ///< m or rad
  double rise_s = 0.0;
};

/// A smooth pulse which takes the floor back to where it was: d = -A sin^4(pi p), whose
/// acceleration has `peak` in the middle and at most 9/16 of it the other way on both sides.
///   A = peak (width_s / (2 pi))^2
struct ImpactCourse {
  double peak = 0.0;  ///< m/s^2 or rad/s^2
  double width_s = 0.0;
};

/// A sine of constant acceleration whose frequency goes from one end to the other, evenly over
/// frequency or over its logarithm, faded in over two periods of from_hz and out over two of to_hz
/// (a quarter of the sweep at most).
///   d = -w(t) A sin(phi(t)) / held_acceleration_gain(f(t)), phi' = 2 pi f
struct SweepCourse {
  double from_hz = 0.0, to_hz = 0.0;
  double amplitude = 0.0;  ///< m/s^2 or rad/s^2
  double sweep_s = 0.0;
  bool linear = false;  ///< else logarithmic
};

/// The phase (rad) of a sweep at a time t (s) from its beginning, and its frequency (Hz).
///   linear: f = f_0 + (f_1 - f_0) t / L; logarithmic: f = f_0 (f_1 / f_0)^(t / L)
double sweep_phase(const SweepCourse& sweep, double t) noexcept;
double sweep_frequency(const SweepCourse& sweep, double t) noexcept;
/// How far a sweep is faded in at t, 0 to 1 and back to 0.
double sweep_fade(const SweepCourse& sweep, double t) noexcept;

/// Positions at the samples of a course from its beginning to its end, the first and the last two
/// at rest. rate: 1/s. Returns m or rad. Errors: std::invalid_argument unless rate > 0 and the
/// course lasts. Set-up.
Eigen::VectorXd positions(const StepCourse& step, double rate);
Eigen::VectorXd positions(const ImpactCourse& impact, double rate);
Eigen::VectorXd positions(const SweepCourse& sweep, double rate);

}  // namespace stillframe::floor
