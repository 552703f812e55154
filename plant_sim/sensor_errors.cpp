#include "plant_sim/sensor_errors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::Index;

namespace {

/// Streams of a seed: processes count on from the first.
enum Stream : std::uint64_t { floor_stream = 0, process_stream = 1 };

/// Of flicker noise: poles a decade, and where they begin and end in terms of its corner.
constexpr double poles_per_decade = 2, lowest_pole = 1e-4;
constexpr int n_poles = 12;

Eigen::VectorXd per_leg(const std::vector<double>& numbers, Index n_legs, const char* what) {
  const auto size = static_cast<Index>(numbers.size());
  if (size == 0) return Eigen::VectorXd::Zero(n_legs);
  if (size == 1) return Eigen::VectorXd::Constant(n_legs, numbers[0]);
  if (size != n_legs) {
    throw std::invalid_argument(std::string("ForceSensorNoise: expected 1 or ") +
                                std::to_string(n_legs) + " numbers of " + what + ", got " +
                                std::to_string(size));
  }
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), size);
}

}  // namespace

ForceSensorProcesses processes_of(const ForceSensorErrors& errors, double sample_time,
                                  double filter_hz) {
  const double power = errors.noise * errors.noise, corner = two_pi * filter_hz;
  ForceSensorProcesses processes{
      .noise = filter_hz > 0
                   ? NoiseProcess::stationary(std::exp(-corner * sample_time), power * corner / 4)
                   : NoiseProcess::stationary(0, power / (2 * sample_time)),
      .walk = {.kept = 1, .fresh = errors.random_walk * std::sqrt(sample_time), .first = 0},
      .flicker = {}};
  if (errors.flicker_below_hz == 0) return processes;
  for (int i = 0; i < n_poles; ++i) {
    const double pole = lowest_pole * errors.flicker_below_hz *
                        std::pow(10, static_cast<double>(i) / poles_per_decade);
    if (pole > 0.5 / sample_time) break;
    processes.flicker.push_back(NoiseProcess::stationary(
        std::exp(-two_pi * pole * sample_time),
        power * errors.flicker_below_hz * std::numbers::ln10 / poles_per_decade));
  }
  return processes;
}

NoiseProcess process_of(const FloorSensorErrors& errors, double sample_time) {
  return NoiseProcess::white(errors.noise / std::sqrt(2 * sample_time));
}

ForceSensorNoise::ForceSensorNoise(Index n_legs, const ForceSensorErrors& errors,
                                   double sample_time, double filter_hz)
    : seed_(errors.seed),
      sample_time_(sample_time),
      range_(errors.range),
      step_(errors.quantisation),
      offset_(per_leg(errors.offset, n_legs, "offset")),
      drift_(per_leg(errors.drift, n_legs, "drift")) {
  // In this order, absent or not, so that each keeps its stream.
  const ForceSensorProcesses processes = processes_of(errors, sample_time, filter_hz);
  add(n_legs, processes.noise);
  add(n_legs, processes.walk);
  for (const NoiseProcess& process : processes.flicker) add(n_legs, process);
}

void ForceSensorNoise::add(Index n_legs, const NoiseProcess& process) {
  const std::uint64_t stream = process_stream + processes_.size();
  Drawn drawn{.process = process, .draws = {}, .x = Eigen::VectorXd::Zero(n_legs)};
  for (Index leg = 0; leg < n_legs; ++leg) {
    drawn.draws.push_back({seed_, {stream, static_cast<std::uint64_t>(leg)}});
    drawn.x(leg) = process.first * drawn.draws.back()(0);
  }
  processes_.push_back(std::move(drawn));
}

void ForceSensorNoise::next() noexcept {
  ++k_;
  for (auto& [process, draws, x] : processes_) {
    if (process.fresh == 0) continue;
    for (Index leg = 0; leg < x.size(); ++leg) {
      x(leg) = process.kept * x(leg) + process.fresh * draws[static_cast<size_t>(leg)](k_);
    }
  }
}

int ForceSensorNoise::apply(Eigen::Ref<Eigen::VectorXd> sigma) const noexcept {
  sigma += offset_ + static_cast<double>(k_) * sample_time_ * drift_;
  for (const Drawn& drawn : processes_) sigma += drawn.x;
  int clipped = 0;
  // The last step of the converter that its range has room for.
  const double most = step_ > 0 ? step_ * std::floor(range_ / step_) : range_;
  for (double& value : sigma) {
    if (std::abs(value) > range_) ++clipped;
    if (step_ > 0) value = step_ * std::nearbyint(value / step_);
    value = std::clamp(value, -most, most);
  }
  return clipped;
}

FloorSensorNoise::FloorSensorNoise(Index n_inputs, const FloorSensorErrors& errors,
                                   double sample_time)
    : deviation_(process_of(errors, sample_time).fresh) {
  for (Index i = 0; i < n_inputs; ++i) {
    draws_.push_back({errors.seed, {floor_stream, static_cast<std::uint64_t>(i)}});
  }
}

void FloorSensorNoise::apply(std::int64_t k,
                             Eigen::Ref<Eigen::VectorXd> acceleration) const noexcept {
  for (Index i = 0; i < acceleration.size(); ++i) {
    acceleration(i) += deviation_ * draws_[static_cast<size_t>(i)](k);
  }
}

}  // namespace stillframe
