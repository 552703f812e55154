#pragma once

#include <filesystem>

#include "controller/loop.hpp"
#include "controller/outcome.hpp"

namespace stillframe::controller {

/// Writes counters and histograms as JSON: n_periods, n_late, n_lost, n_duplicate, and the
/// histograms wake_up, receive, compute and publish as Histogram::to_json. Set-up.
/// Errors: those of WholeFile.
void write_timing_file(const std::filesystem::path& file, const Counters& counters,
                       const LoopTimes& times);

}  // namespace stillframe::controller
