#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace stillframe::report {

/// A generic vibration criterion: a limit on the rms velocity of each one-third-octave band up to
/// 80 Hz. VC-A and VC-B apply from 4 Hz on and are limits of constant acceleration up to 8 Hz (260
/// and 130 micro-g), the others apply from 1 Hz on and are limits of constant velocity throughout.
/// Source: C. G. Gordon, Generic criteria for vibration-sensitive equipment, Proc. SPIE 1619
/// (1991), and its revision by Amick, Gendreau, Busch and Gordon, Proc. SPIE 5933 (2005), which
/// adds F and G; the ranges are those of IEST-RP-CC012.
struct VibrationCriterion {
  std::string name;      ///< VC-A ... VC-G
  double velocity = 0;   ///< m/s rms at 8 Hz and above
  double lowest_hz = 1;  ///< nominal centre of the lowest band that it limits; 4 Hz: limit times
                         ///< 8 Hz / f below 8 Hz

  /// Whether the band with this centre, Hz, is limited.
  bool applies(double frequency_hz) const;
  /// The limit at a frequency, m/s rms; infinite where there is none. frequency_hz in Hz.
  double limit(double frequency_hz) const;
};

/// VC-A to VC-G, from the loosest to the strictest.
const std::vector<VibrationCriterion>& vibration_criteria();

/// The strictest criterion met in every band that it limits, "above VC-A" if none is, or "not
/// known" if a band was not observed and none that was rules VC-A out. band_velocity: rms velocity
/// of each of third_octave_bands(), m/s; NaN: not observed.
/// Errors: std::invalid_argument for another number of bands.
std::string vibration_class(const Eigen::VectorXd& band_velocity);

/// Whether a band that was observed is above the limit of a criterion, VC-A to VC-G. band_velocity
/// and errors as for vibration_class; std::out_of_range for a name that is none.
bool exceeds(const Eigen::VectorXd& band_velocity, const std::string& criterion);

}  // namespace stillframe::report
