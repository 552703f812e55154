#pragma once

#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace stillframe::floor {

/// A vibration criterion as a noise: in every one-third-octave band from 1 to 80 Hz the rms
/// velocity is that of the class, and nothing moves outside these bands.
///   S_a = (2 pi)^2 V^2 f / (ln(10) / 10), and of A and B in the bands below 8 Hz, where the
///   acceleration of a band is limited, S_a = (2 pi 8 Hz V)^2 / (f sinh(ln(10) / 10))
/// Source: IEST-RP-CC012; Amick, Gendreau, Busch and Gordon, Proc. SPIE 5933 (2005).
struct VibrationCriterionDensity {
  char letter = 'D';  ///< A to G
};

/// Peterson's new high- or low-noise model, PSD of acceleration in dB: A + B log10(1 / f); nothing
/// above 10 Hz, where the models end, and below 1e-5 Hz. Source: J. Peterson, Observations and
/// modeling of seismic background noise, USGS Open-File Report 93-322 (1993).
struct PetersonDensity {
  bool high = false;
};

/// Straight lines between points in logarithms of both; nothing outside.
struct PointsDensity {
  std::vector<std::pair<double, double>> points;  ///< Hz, ascending; unit^2/Hz
};

/// A one-sided power spectral density, of an acceleration in (m/s^2)^2/Hz unless its block says
/// otherwise.
using Density = std::variant<VibrationCriterionDensity, PetersonDensity, PointsDensity>;

/// The letters of the vibration criteria.
inline constexpr std::string_view criterion_letters = "ABCDEFG";

/// Rms velocity of a criterion at 8 Hz and above, m/s.
double criterion_velocity(char letter);

/// The density at a frequency above 0 Hz.
double density_at(const Density& density, double frequency_hz);

}  // namespace stillframe::floor
