#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/loop_checkpoint_t.hpp"
#include "stillframe_msgs/loop_record_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"

namespace stillframe::tools {

/// One loop from its first period to its last: what it met, and its memory before some of the
/// periods.
struct LoopSession {
  std::vector<stillframe_msgs::loop_record_t> records;
  std::map<std::int64_t, stillframe_msgs::loop_checkpoint_t> checkpoints;  ///< by their period
};

/// All of one run from which its commands can be computed again, in the order of the log.
struct ReplayLog {
  stillframe_msgs::run_info_t info;
  std::vector<stillframe_msgs::measurement_t> measurements;  ///< of lock-step runs
  std::vector<stillframe_msgs::command_t> commands;          ///< repeats left out
  std::vector<LoopSession> sessions;                         ///< of wall-clock runs
  std::int64_t n_damaged = 0;  ///< events that could not be read or decoded
};

/// Reads an LCM log or a flight record; run_id chooses the run where there are several. Set-up.
/// Errors: InputError for a missing file, no run_info, several runs and no choice, sizes that do
/// not fit run_info, or nothing that could be replayed.
ReplayLog read_replay_log(const std::filesystem::path& path, std::optional<std::int64_t> run_id);

}  // namespace stillframe::tools
