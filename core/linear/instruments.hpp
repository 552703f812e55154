#pragma once

namespace stillframe {

/// What stands between a law and the legs, alike for every leg. Values of their own mean "not
/// there".
struct Instruments {
  /// Which force the measurement reports as applied: the one that acts, or the command behind it.
  enum class Report { measured, commanded };

  double actuator_gain = 1;     ///< force that acts over force that is reported, 1
  double actuator_lag_hz = 0;   ///< corner of amplifier and actuator, first order; 0: none
  double sensor_filter_hz = 0;  ///< corner of the low-pass before sigma is sampled; 0: none
  Report report = Report::measured;
  int report_age_samples = 0;  ///< samples by which the reported force is older than sigma

  /// True if nothing stands there.
  bool ideal() const {
    return actuator_gain == 1 && actuator_lag_hz == 0 && sensor_filter_hz == 0 &&
           report_age_samples == 0;
  }
};

}  // namespace stillframe
