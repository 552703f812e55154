#pragma once

#include <Eigen/Core>
#include <random>
#include <string>
#include <vector>

namespace stillframe::controller {

/// What is wrong with one or two legs from some sample on: on the way from the sensor, from the
/// read-back of the actuator, or in the actuator, whose read-back then tells the truth.
enum class Part { sensor, read_back, actuator };
enum class Damage {
  open,     ///< a noise
  shorted,  ///< zero
  stuck,    ///< what it was
  swapped,  ///< with the next leg
  reversed,
  scaled,     ///< `size` times what it is
  offset,     ///< and `size` N
  drifts,     ///< by `size` N/s
  spikes,     ///< of `size` N, one sample in a hundred
  quantised,  ///< to steps of `size` N
  late,       ///< by one sample
  early,      ///< by one sample: a command acts, or is said to act, sooner than designed
  lags        ///< as behind a low-pass of `size` Hz
};

struct Broken {
  Part part;
  Damage damage;
  double size = 0;
  std::string damage_name() const;  ///< "scaled 0.5"
  std::string name() const;         ///< "sensor scaled 0.5"
};

/// Every part with every damage, but for a sensor that is early: none tells what has not happened.
std::vector<Broken> all_broken();

/// Changes the values of one leg, sample by sample.
class Breaker {
 public:
  /// noise: N, rms of what an open cable picks up.
  Breaker(const Broken& broken, Eigen::Index leg, double sample_time, double noise,
          std::uint64_t seed);
  /// next: forces that are on their way, and come a sample after these.
  void operator()(Eigen::VectorXd& values, const Eigen::VectorXd& next);

 private:
  Broken broken_;
  Eigen::Index leg_;
  double sample_time_, noise_, t_ = 0, held_ = 0;
  bool first_ = true;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

}  // namespace stillframe::controller
