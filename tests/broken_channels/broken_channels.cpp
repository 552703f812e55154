#include "tests/broken_channels/broken_channels.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

namespace stillframe::controller {

std::string Broken::damage_name() const {
  constexpr const char* damages[] = {"open",   "shorted", "stuck",  "swapped", "reversed",
                                     "scaled", "offset",  "drifts", "spikes",  "quantised",
                                     "late",   "early",   "lags"};
  std::string text = damages[static_cast<int>(damage)];
  if (size == 0) return text;
  char number[32];
  std::snprintf(number, sizeof number, " %g", size);
  return text + number;
}

std::string Broken::name() const {
  constexpr const char* parts[] = {"sensor", "read-back", "actuator"};
  return std::string(parts[static_cast<int>(part)]) + " " + damage_name();
}

std::vector<Broken> all_broken() {
  std::vector<Broken> all;
  for (const Part part : {Part::sensor, Part::read_back, Part::actuator}) {
    for (const Damage damage :
         {Damage::open, Damage::shorted, Damage::stuck, Damage::swapped, Damage::reversed}) {
      all.push_back({part, damage});
    }
    for (const double gain : {0.5, 0.7, 0.9, 1.1, 1.3, 1.5}) {
      all.push_back({part, Damage::scaled, gain});
    }
    for (const double offset : {0.1, 1.0, 10.0}) all.push_back({part, Damage::offset, offset});
    for (const double rate : {0.1, 1.0, 10.0}) all.push_back({part, Damage::drifts, rate});
    for (const double spike : {0.1, 1.0, 10.0}) all.push_back({part, Damage::spikes, spike});
    for (const double step : {0.01, 0.1}) all.push_back({part, Damage::quantised, step});
    all.push_back({part, Damage::late});
    if (part != Part::sensor) all.push_back({part, Damage::early});
    for (const double corner : {50.0, 300.0}) all.push_back({part, Damage::lags, corner});
  }
  return all;
}

Breaker::Breaker(const Broken& broken, Eigen::Index leg, double sample_time, double noise,
                 std::uint64_t seed)
    : broken_(broken), leg_(leg), sample_time_(sample_time), noise_(noise), random_(seed) {}

void Breaker::operator()(Eigen::VectorXd& values, const Eigen::VectorXd& next) {
  double& value = values(leg_);
  const double size = broken_.size;
  t_ += sample_time_;
  if (std::exchange(first_, false)) held_ = value;
  switch (broken_.damage) {
    case Damage::open:
      value = noise_ * normal_(random_);
      return;
    case Damage::shorted:
      value = 0;
      return;
    case Damage::stuck:
      value = held_;
      return;
    case Damage::swapped:
      std::swap(value, values((leg_ + 1) % values.size()));
      return;
    case Damage::reversed:
      value = -value;
      return;
    case Damage::scaled:
      value *= size;
      return;
    case Damage::offset:
      value += size;
      return;
    case Damage::drifts:
      value += size * t_;
      return;
    case Damage::spikes:
      if (random_() % 100 == 0) value += random_() % 2 == 0 ? size : -size;
      return;
    case Damage::quantised:
      value = size * std::round(value / size);
      return;
    case Damage::late:
      value = std::exchange(held_, value);
      return;
    case Damage::early:
      value = next(leg_);
      return;
    case Damage::lags:
      held_ += (1 - std::exp(-2 * std::numbers::pi * size * sample_time_)) * (value - held_);
      value = held_;
      return;
  }
}

}  // namespace stillframe::controller
