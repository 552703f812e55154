#pragma once

#include <filesystem>
#include <optional>

#include "report/analysis/loop_response.hpp"
#include "stillframe_msgs/run_info_t.hpp"

namespace stillframe::tools {

/// When the controller of an active wall-clock run took hold of its frame, by its own records; none
/// of other runs. The log is read up to there. What it let go of later is not looked for. Errors:
/// InputError if the log cannot be read or has no record.
std::optional<report::Takeover> takeover_of(const std::filesystem::path& log,
                                            const stillframe_msgs::run_info_t& info);

}  // namespace stillframe::tools
