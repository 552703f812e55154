#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/systems/instruments.hpp"
#include "core/systems/noise_power.hpp"
#include "plant_sim/counter_noise.hpp"

namespace stillframe {

/// The noises of every force sensor, each leg's its own, as ForceSensorNoise draws them.
struct ForceSensorProcesses {
  NoiseProcess noise, walk;
  NoiseKind flicker;  ///< none above half the sample rate
};

/// sample_time: T_s, s. filter_hz: corner of the sensor filter, 0 if there is none. The equations
/// stand at ForceSensorNoise.
ForceSensorProcesses processes_of(const ForceSensorErrors& errors, double sample_time,
                                  double filter_hz);

/// White noise of every floor accelerometer, of variance S^2 / (2 T_s).
NoiseProcess process_of(const FloorSensorErrors& errors, double sample_time);

/// What the force sensors make of sigma at t_k = k T_s,
///   Q(min(r, max(-r, sigma + v + b + o + d t_k + W))),
/// o offset, d drift, r range, Q to the nearest step of the converter within the range, and
///   v: noise of one-sided density S. Without a sensor filter white up to half the sample rate, of
///      variance S^2 / (2 T_s); behind one of corner omega_s white noise that it has passed, of
///      variance S^2 omega_s / 4, v[k+1] = a v[k] + ..., a = exp(-omega_s T_s);
///   b: flicker of density S^2 f_c / f, behind the filter: a sum of first-order processes of
///      variance S^2 f_c ln r at poles f_i a factor r = 10^(1/2) apart, from 1e-4 f_c to
///      10^(3/2) f_c or half the sample rate, since
///      integral of (2 / pi) f_i / (f_i^2 + f^2) d ln f_i = 1 / f;
///   W: random walk, W[k+1] = W[k] + w sqrt(T_s) xi[k].
/// Every number drawn depends on the seed, its use, the leg and k alone. Set-up: construction. The
/// rest is hot: noexcept, no allocation.
class ForceSensorNoise {
 public:
  /// At k = 0. sample_time: T_s, s. filter_hz: corner of the sensor filter, 0 if there is none.
  /// Errors: std::invalid_argument if a list is neither empty nor of 1 or n_legs numbers.
  ForceSensorNoise(Eigen::Index n_legs, const ForceSensorErrors& errors, double sample_time,
                   double filter_hz);

  /// On to the next sample.
  void next() noexcept;
  /// sigma (n_legs, N) as it is read in this sample; answers how many legs were out of range.
  int apply(Eigen::Ref<Eigen::VectorXd> sigma) const noexcept;

 private:
  struct Drawn {
    NoiseProcess process;
    std::vector<CounterNoise> draws;  ///< one for each leg
    Eigen::VectorXd x;                ///< n_legs, N
  };

  void add(Eigen::Index n_legs, const NoiseProcess& process);

  std::uint64_t seed_;
  double sample_time_, range_, step_;
  Eigen::VectorXd offset_, drift_;  ///< n_legs, N and N/s
  std::vector<Drawn> processes_;
  std::int64_t k_ = 0;
};

/// What the floor accelerometers add: white noise up to half the sample rate, of variance
/// S^2 / (2 T_s). Set-up: construction. The rest is hot: noexcept, no allocation.
class FloorSensorNoise {
 public:
  FloorSensorNoise(Eigen::Index n_inputs, const FloorSensorErrors& errors, double sample_time);

  /// Adds the noise of sample k to accelerations (n_inputs, m/s^2).
  void apply(std::int64_t k, Eigen::Ref<Eigen::VectorXd> acceleration) const noexcept;

 private:
  double deviation_;
  std::vector<CounterNoise> draws_;
};

}  // namespace stillframe
