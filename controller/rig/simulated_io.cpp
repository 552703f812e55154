#include "controller/rig/simulated_io.hpp"

#include <cmath>
#include <cstdlib>
#include <utility>

#include "msgs/clock.hpp"

namespace stillframe::controller {

namespace {

constexpr double default_rms = 0.003, largest_rms = 1000;
constexpr std::int64_t most_at_once = 1000;  // samples; what slept for longer does not catch up

double floor_rms_of(const DriverSetting& setting) {
  const auto found = setting.options.find("floor_rms");
  if (found == setting.options.end()) return default_rms;
  char* end = nullptr;
  const double value = std::strtod(found->second.c_str(), &end);
  if (!found->second.empty() && *end == 0 && value >= 0 && value <= largest_rms) return value;
  setting.fail("floor_rms", "found '" + found->second + "', allowed is a number from 0 to 1000");
}

}  // namespace

SimulatedIo::SimulatedIo(const DriverSetting& setting)
    : SimulatedIo(SimulatedPlant(*setting.gains, floor_rms_of(setting)), setting.n_legs) {}

SimulatedIo::SimulatedIo(SampledPlant plant, double floor_rms)
    : SimulatedIo(SimulatedPlant(plant, floor_rms), plant.Gamma_u.cols()) {}

SimulatedIo::SimulatedIo(SimulatedPlant plant, Eigen::Index n_legs)
    : plant_(std::move(plant)), start_ns_(monotonic_ns()), force_(Eigen::VectorXd::Zero(n_legs)) {}

bool SimulatedIo::receive(Measurement& m) noexcept {
  const double period_ns = plant_.sample_time() * ns_per_s;
  const auto now =
      static_cast<std::int64_t>(static_cast<double>(monotonic_ns() - start_ns_) / period_ns);
  if (seq_ >= now) return false;
  if (now - seq_ > most_at_once) {
    start_ns_ += std::llround(static_cast<double>(now - seq_ - 1) * period_ns);
  }
  if (seq_ >= 0) plant_.advance(force_);
  ++seq_;
  plant_.read(m);
  m.seq = seq_;
  m.received_ns = start_ns_ + std::llround(static_cast<double>(seq_) * period_ns);
  return true;
}

}  // namespace stillframe::controller
