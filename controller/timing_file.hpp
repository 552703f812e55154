#pragma once

#include <filesystem>

#include "controller/loop.hpp"
#include "stillframe_msgs/timing_t.hpp"

namespace stillframe::controller {

/// Writes counters and histograms as JSON: n_periods, n_late, n_lost, n_duplicate, and the
/// histograms wake_up, receive, compute and publish as Histogram::to_json. Set-up.
/// Errors: those of WholeFile.
void write_timing_file(const std::filesystem::path& file, const stillframe_msgs::timing_t& counters,
                       const LoopTimes& times);

}  // namespace stillframe::controller
