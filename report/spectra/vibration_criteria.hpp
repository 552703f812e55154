#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace stillframe::report {

/// A generic vibration criterion: a limit on the rms velocity of each one-third-octave band, 1-80
/// Hz. VC-A and VC-B are limits of constant acceleration below 8 Hz, the others of constant
/// velocity throughout. Source: C. G. Gordon, Generic criteria for vibration-sensitive equipment,
/// Proc. SPIE 1619 (1991), and its revision by Amick, Gendreau, Busch and Gordon, Proc. SPIE 5933
/// (2005), which adds F and G.
struct VibrationCriterion {
  std::string name;                 ///< VC-A ... VC-G
  double velocity = 0;              ///< m/s rms at 8 Hz and above
  bool relaxed_below_8_hz = false;  ///< limit times 8 Hz / f below 8 Hz

  /// The limit at a frequency, m/s rms; frequency_hz in Hz.
  double limit(double frequency_hz) const;
};

/// VC-A to VC-G, from the loosest to the strictest.
const std::vector<VibrationCriterion>& vibration_criteria();

/// The strictest criterion met in every band, or "above VC-A" if none is.
/// band_velocity: rms velocity of each of third_octave_bands(), m/s.
/// Errors: std::invalid_argument for another number of bands.
std::string vibration_class(const Eigen::VectorXd& band_velocity);

}  // namespace stillframe::report
