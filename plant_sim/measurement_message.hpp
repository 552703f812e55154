#pragma once

#include <cstdint>

#include "plant_sim/plant.hpp"
#include "stillframe_msgs/measurement_t.hpp"

namespace stillframe {

/// Writes sample k of a run at a rate (Hz) from what the instruments read: all but the run's id.
/// The one way from a reading to a message, for runs over LCM and for those in one process.
void write_measurement(const Reading& reading, std::int64_t k, double sample_rate_hz,
                       stillframe_msgs::measurement_t& message);

}  // namespace stillframe
