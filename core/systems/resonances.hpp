#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/numerics/singular_values.hpp"
#include "core/systems/frequency_sweep.hpp"
#include "core/systems/linear_system.hpp"
#include "core/systems/sampled_loop.hpp"

namespace stillframe {

/// Where a pole s makes a response peak: at |Im s| / 2 pi, as wide to either side as |Re s| / 2 pi.
struct Resonance {
  double hz = 0, half_width_hz = 0;

  /// No narrower than rounding: the response has no value there.
  bool undamped() const { return half_width_hz < 1e-9 * hz; }
};

/// The resonances among poles (rad/s), ascending: those with a damping ratio below 0.3. Others are
/// as wide as the steps of any grid.
std::vector<Resonance> resonances(const Eigen::VectorXcd& poles);
/// Among poles z of a sampled system; sample_time in s.
std::vector<Resonance> resonances(const Eigen::VectorXcd& poles, double sample_time);

/// The one rule of what a curve of a response shows: its grid (ascending, Hz) and, about every
/// resonance between the grid's ends, points a quarter of the half-width apart (which reads a peak
/// 0.07 dB low at most), and ever farther out until the grid's own are as near. The frequency of an
/// undamped pole itself is left out.
Eigen::VectorXd with_resonances(const Eigen::VectorXd& grid_hz,
                                const std::vector<Resonance>& resonances);

/// The largest singular value of a response and where it may peak.
class LargestGain {
 public:
  /// Of a continuous system. Errors: as FrequencySweep.
  explicit LargestGain(const StateSpace& system);
  /// Of y from the first n_inputs inputs.
  LargestGain(const LinearSystem& system, Eigen::Index n_inputs);
  /// Of y from w of a sampled loop.
  explicit LargestGain(const SampledLoop& loop);

  /// NaN where the response has no value.
  double operator()(double hz);
  const std::vector<Resonance>& resonances() const { return resonances_; }

 private:
  LargestGain(const StateSpace& system, double sample_time);
  FrequencySweep sweep_;
  SingularValues decomposition_;
  double sample_time_;  ///< s; 0: continuous
  Eigen::MatrixXcd G_;
  std::vector<Resonance> resonances_;
};

struct Peak {
  double hz = 0, value = 0;
};

/// The rows that a table needs beside its own: between two neighbours of rows_hz (ascending) the
/// highest point of a response, where that is more than 1 dB above both of them. Infinite at an
/// undamped resonance that the response has.
std::vector<Peak> peaks_between(const Eigen::VectorXd& rows_hz, LargestGain& gain);

}  // namespace stillframe
