#include "plant_sim/force_sensors.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::Index;

namespace {

/// b times the integral of exp(-a tau - b (t - tau)) over tau from 0 to t,
///   b (exp(-a t) - exp(-b t)) / (b - a),
/// the answer of a low-pass of rate b to exp(-a t). By the slower of the two rates and their
/// difference it neither overflows nor cancels, and a = b is no exception.
double answer(double a, double b, double t) {
  const double slow = std::min(a, b), x = std::abs(b - a) * t;
  return b * t * std::exp(-slow * t) * (x == 0 ? 1 : -std::expm1(-x) / x);
}

/// Exponentials of this argument are below the rounding of 1.
constexpr double forgotten = 40;

/// Nodes and weights of Gauss and Legendre for eight points on [-1, 1]; the other half mirrors.
struct GaussPoint {
  double node, weight;
};
constexpr std::array<GaussPoint, 4> gauss_points{
    {{0.18343464249564980494, 0.36268378337836198297},
     {0.52553240991632898582, 0.31370664587788728734},
     {0.79666647741362673959, 0.22238103445337447054},
     {0.96028985649753623168, 0.10122853629037625915}}};

/// The integral of f from a to b in panels of at most three time constants: on those eight points
/// leave 2e-15 of an exponential.
template <typename F>
double integral(const F& f, double a, double b, double rate) {
  if (!(b > a)) return 0;
  const auto n = static_cast<int>(std::ceil((b - a) * rate / 3));
  const double half = (b - a) / std::max(n, 1) / 2;
  double sum = 0;
  for (int i = 0; i < std::max(n, 1); ++i) {
    const double middle = a + (2 * i + 1) * half;
    for (const auto& [node, weight] : gauss_points) {
      sum += weight * (f(middle - half * node) + f(middle + half * node));
    }
  }
  return half * sum;
}

}  // namespace

ForceSensors::ForceSensors(Index n_legs, double corner_hz)
    : rate_(two_pi * corner_hz), s_a_(Eigen::VectorXd::Zero(n_legs)) {}

double ForceSensors::unsettled(Index leg, double duration,
                               const Actuators& actuators) const noexcept {
  const double settled = actuators.settled(leg), slewing = actuators.slewing_ends(leg);
  const double rate = rate_ + actuators.fastest_rate(leg);
  const auto integrand = [&](double t) {
    return rate_ * std::exp(-rate_ * (duration - t)) * (actuators.acting(leg, t) - settled);
  };
  // Before, the filter has forgotten it; after, the actuator has settled.
  const double from = std::max(0.0, duration - forgotten / rate_);
  const double lag = actuators.rate() > 0 ? forgotten / actuators.rate() : 0;
  const double to = std::min(duration, slewing + lag);
  const double crossing = actuators.loop_crosses(leg);
  const double first = std::clamp(std::min(slewing, crossing), from, std::max(from, to));
  const double second = std::clamp(std::max(slewing, crossing), from, std::max(from, to));
  return integral(integrand, from, first, rate) + integral(integrand, first, second, rate) +
         integral(integrand, second, to, rate);
}

void ForceSensors::finish(double duration, const Actuators& actuators) noexcept {
  if (!filter()) return;
  const double kept = std::exp(-rate_ * duration);
  const double lagged = actuators.exponential() ? answer(actuators.rate(), rate_, duration) : 0;
  const bool shaped = actuators.lags() && !actuators.exponential();
  for (Index leg = 0; leg < s_a_.size(); ++leg) {
    const double settled = actuators.settled(leg);
    s_a_(leg) = settled + kept * (s_a_(leg) - settled) +
                (shaped ? unsettled(leg, duration, actuators) : lagged * actuators.transient(leg));
  }
}

}  // namespace stillframe
