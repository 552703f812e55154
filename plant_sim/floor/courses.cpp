#include "plant_sim/floor/courses.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/numerics/smooth_step.hpp"
#include "core/numerics/two_pi.hpp"
#include "plant_sim/floor/held_acceleration.hpp"

namespace stillframe::floor {

namespace {

/// position(t) at t = 0, 1 / rate, ... until it has been at rest for a sample.
template <typename Position>
Eigen::VectorXd tabulate(double length_s, double rate, const Position& position) {
  if (!(rate > 0.0) || !(length_s > 0.0)) {
    throw std::invalid_argument("positions: expected a rate and a length above 0, got " +
                                std::to_string(rate) + " and " + std::to_string(length_s));
  }
  Eigen::VectorXd course(static_cast<Eigen::Index>(std::ceil(length_s * rate)) + 2);
  for (Eigen::Index k = 0; k < course.size(); ++k) {
    course(k) = position(std::min(static_cast<double>(k) / rate, length_s));
  }
  return course;
}

}  // namespace

double sweep_frequency(const SweepCourse& sweep, double t) noexcept {
  const double p = t / sweep.sweep_s;
  return sweep.linear ? sweep.from_hz + (sweep.to_hz - sweep.from_hz) * p
                      : sweep.from_hz * std::pow(sweep.to_hz / sweep.from_hz, p);
}

double sweep_phase(const SweepCourse& sweep, double t) noexcept {
  const double p = t / sweep.sweep_s;
  if (sweep.linear) {
    return two_pi * (sweep.from_hz * t + 0.5 * (sweep.to_hz - sweep.from_hz) * p * t);
  }
  const double ratio = std::log(sweep.to_hz / sweep.from_hz);
  return two_pi * sweep.from_hz * sweep.sweep_s * std::expm1(ratio * p) / ratio;
}

double sweep_fade(const SweepCourse& sweep, double t) noexcept {
  const double fade_in = std::min(2.0 / sweep.from_hz, 0.25 * sweep.sweep_s);
  const double fade_out = std::min(2.0 / sweep.to_hz, 0.25 * sweep.sweep_s);
  return smooth_step(t / fade_in) * smooth_step((sweep.sweep_s - t) / fade_out);
}

Eigen::VectorXd positions(const StepCourse& step, double rate) {
  return tabulate(step.rise_s, rate,
                  [&](double t) { return step.height * smooth_step(t / step.rise_s); });
}

Eigen::VectorXd positions(const ImpactCourse& impact, double rate) {
  const double size = impact.peak * std::pow(impact.width_s / two_pi, 2);
  return tabulate(impact.width_s, rate, [&](double t) {
    if (t >= impact.width_s) return 0.0;  // sin(pi) rounds to more than nothing
    const double sine = std::sin(std::numbers::pi * t / impact.width_s);
    return -size * std::pow(sine, 4);
  });
}

Eigen::VectorXd positions(const SweepCourse& sweep, double rate) {
  return tabulate(sweep.sweep_s, rate, [&](double t) {
    const double gain = held_acceleration_gain(sweep_frequency(sweep, t), rate);
    return -sweep_fade(sweep, t) * sweep.amplitude / gain * std::sin(sweep_phase(sweep, t));
  });
}

}  // namespace stillframe::floor
