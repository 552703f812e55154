#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "stillframe_msgs/run_info_t.hpp"

namespace stillframe::report {

/// What a run says of itself, as its log has it: the first run with measurements, or the chosen
/// one. A run_info is sent several times; where copies differ, most of them are believed. Reads no
/// further than to the first measurement of the run. With a plant, what other plants said of the
/// run and measured of it is not there. Bytes of texts that are no UTF-8 are replaced. Errors:
/// InputError for a missing file, no run_info, no such run, a run without measurements, another
/// format_version, a sample rate that is none.
stillframe_msgs::run_info_t find_run_info(const std::filesystem::path& path,
                                          std::optional<std::int64_t> run_id,
                                          std::optional<std::int64_t> plant_instance,
                                          const std::function<void(double)>& progress);

}  // namespace stillframe::report
