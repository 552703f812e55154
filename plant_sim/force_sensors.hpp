#pragma once

#include <Eigen/Core>

#include "plant_sim/actuators.hpp"

namespace stillframe {

/// The low-pass of all force sensors, s' = omega_s (sigma - s) with sigma = sigma_a + sigma_e, in
/// two parts: s_a, the answer to the actuators, jumps in them included, in closed form, or where
/// they slew or lag with hysteresis by quadrature to the last digits; and
/// s_e' = omega_s (sigma_e - s_e), the answer to the elastic stress, which the integrator of the
/// motion takes along. Set-up: construction. The rest is hot: noexcept, no allocation.
class ForceSensors {
 public:
  /// At rest. corner_hz: omega_s / 2 pi, 0 if there is no filter.
  ForceSensors(Eigen::Index n_legs, double corner_hz);

  bool filter() const noexcept { return rate_ > 0; }
  /// omega_s, 1/s.
  double rate() const noexcept { return rate_; }
  /// s_a goes on for a duration (s) under the command that stands; before Actuators::finish.
  void finish(double duration, const Actuators& actuators) noexcept;
  /// s_a (n_legs, N).
  const Eigen::VectorXd& actuator_part() const noexcept { return s_a_; }

 private:
  /// The answer to sigma_a - settled of a leg at the end of a duration (s).
  double unsettled(Eigen::Index leg, double duration, const Actuators& actuators) const noexcept;

  double rate_;
  Eigen::VectorXd s_a_;
};

}  // namespace stillframe
