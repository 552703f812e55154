#include "plant_sim/force_sensors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stillframe {

namespace {

/// b times the integral of exp(-a tau - b (t - tau)) over tau from 0 to t,
///   b (exp(-a t) - exp(-b t)) / (b - a),
/// the answer of a low-pass of rate b to exp(-a t). By the slower of the two rates and their
/// difference it neither overflows nor cancels, and a = b is no exception.
double answer(double a, double b, double t) {
  const double slow = std::min(a, b), x = std::abs(b - a) * t;
  return b * t * std::exp(-slow * t) * (x == 0 ? 1 : -std::expm1(-x) / x);
}

}  // namespace

ForceSensors::ForceSensors(Eigen::Index n_legs, double corner_hz)
    : rate_(2 * std::numbers::pi * corner_hz), s_a_(Eigen::VectorXd::Zero(n_legs)) {}

void ForceSensors::finish(double duration, const Actuators& actuators) noexcept {
  if (!filter()) return;
  const double kept = std::exp(-rate_ * duration);
  const double lagged = actuators.lags() ? answer(actuators.rate(), rate_, duration) : 0;
  for (Eigen::Index leg = 0; leg < s_a_.size(); ++leg) {
    const double settled = actuators.settled(leg);
    s_a_(leg) = settled + kept * (s_a_(leg) - settled) + lagged * actuators.transient(leg);
  }
}

}  // namespace stillframe
