#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/numerics/infinity.hpp"

namespace stillframe {

/// Loop of a piezo's force over its drive as a data sheet gives it; core/systems/bouc_wen.hpp.
struct HysteresisLoop {
  double width = 0;            ///< at its widest over the range of the force, 1
  double swing_n = 0;          ///< N, the drive goes to and fro between minus and plus this
  double saturation_n = 0;     ///< N, change of drive within which a turned branch bends, 1 / beta
  double gamma_over_beta = 0;  ///< of Bouc and Wen, above -1 up to 1
};

/// What the force sensors of the legs add to sigma. Values of their own mean "not there"; a list is
/// empty, one number for all legs, or one for each.
struct ForceSensorErrors {
  double noise = 0;                 ///< N/sqrt(Hz), one-sided density, white before the filter
  double flicker_below_hz = 0;      ///< below it 1/f noise is above the white
  double random_walk = 0;           ///< N/sqrt(s)
  std::vector<double> offset = {};  ///< N
  std::vector<double> drift = {};   ///< N/s
  double range = infinity;          ///< N
  double quantisation = 0;          ///< N, one step of the converter
  std::uint64_t seed = 1;
};

/// What the floor accelerometers add.
struct FloorSensorErrors {
  double noise = 0;  ///< m/s^2/sqrt(Hz), one-sided density, white
  std::uint64_t seed = 1;
};

/// What stands between a law and the legs, alike for every leg. Values of their own mean "not
/// there". The analysis counts the linear part; the rest is the plant simulator's alone.
struct Instruments {
  /// Which force the measurement reports as applied: the one that acts, or the command behind it.
  enum class Report { measured, commanded };

  double actuator_gain = 1;     ///< force that acts over force that is reported, 1
  double actuator_lag_hz = 0;   ///< corner of amplifier and actuator, first order; 0: none
  double sensor_filter_hz = 0;  ///< corner of the low-pass before sigma is sampled; 0: none
  Report report = Report::measured;
  int report_age_samples = 0;  ///< samples by which the reported force is older than sigma

  /// N/s, fastest change of the force of an amplifier.
  double force_rate_limit = infinity;
  std::optional<HysteresisLoop> hysteresis = {};
  std::optional<ForceSensorErrors> force_sensors = {};
  std::optional<FloorSensorErrors> floor_sensors = {};

  /// True if nothing stands there that the analysis counts.
  bool ideal() const {
    return actuator_gain == 1 && actuator_lag_hz == 0 && sensor_filter_hz == 0 &&
           report_age_samples == 0;
  }
};

}  // namespace stillframe
