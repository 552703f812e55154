#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace stillframe {

/// Orthogonal multisine experiments, one block for each channel, every line on every channel at
/// once. Block b begins with a transition of ramp_s, in which the phasors glide from those of block
/// b - 1 (zero before block 0) to their own, then window_s of steady sinusoids follow, in which
/// channel i has
///   w_i(t) = Re sum_l A exp(j phi_l) exp(2 pi j i b / n_blocks) exp(2 pi j f_l t),  t from the
///   first sample,
/// A = amplitude sqrt(2 / number of lines). The phasor matrix W of a line (channels x blocks) has
/// W W^H = n_blocks A^2 I.
struct MultisinePlan {
  double sample_rate_hz = 0.0;
  std::vector<double> frequencies_hz;   ///< ascending, whole multiples of 4 / window_s
  Eigen::Index n_blocks = 0;            ///< number of blocks, and of channels
  double ramp_s = 4.0, window_s = 8.0;  ///< whole numbers of samples
  double amplitude = 0.0;               ///< m/s^2 rms of each channel in a window

  Eigen::Index ramp_samples() const { return std::llround(ramp_s * sample_rate_hz); }
  Eigen::Index window_samples() const { return std::llround(window_s * sample_rate_hz); }
  Eigen::Index n_samples() const { return n_blocks * (ramp_samples() + window_samples()); }
  /// The first sample of the steady window of a block.
  Eigen::Index window_begin(Eigen::Index block) const {
    return block * (ramp_samples() + window_samples()) + ramp_samples();
  }
};

}  // namespace stillframe
