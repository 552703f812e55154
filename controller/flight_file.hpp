#pragma once

#include <filesystem>

#include "controller/flight_recorder.hpp"
#include "stillframe_msgs/run_info_t.hpp"

namespace stillframe::controller {

/// Writes what a flight recorder that stands still holds as an LCM log: run_info, then checkpoints
/// and records in the order of their periods. Set-up. Errors: those of WholeFile.
void write_flight_file(const std::filesystem::path& file, const stillframe_msgs::run_info_t& info,
                       const FlightRecorder& recorder, const std::string& policy_text);

}  // namespace stillframe::controller
