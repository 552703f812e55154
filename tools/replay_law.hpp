#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "controller/gains.hpp"
#include "controller/policy.hpp"
#include "tools/replay_log.hpp"

namespace stillframe::tools {

/// Where a log and the same law on the same measurements part.
struct ReplayDifference {
  std::string channel;      ///< of the message that differs
  std::int64_t seq = 0;     ///< of the command
  std::int64_t period = 0;  ///< of the loop; 0 in lock-step runs
  std::string field;        ///< force, saturated, time_ns, sent, state, fault or memory
  std::string leg;          ///< name; empty where it is no field of a leg
  double recorded = 0, computed = 0;
};

/// What a replay found.
struct ReplayResult {
  std::int64_t n_commands = 0;      ///< computed again and compared
  std::int64_t n_different = 0;     ///< of these
  std::int64_t n_periods = 0;       ///< of wall-clock loops, computed again and compared
  std::int64_t n_gaps = 0;          ///< where records are missing
  std::int64_t n_not_computed = 0;  ///< records between a gap and the next checkpoint
  std::int64_t n_not_logged = 0;    ///< computed commands that are not among the log's commands
  std::int64_t n_other = 0;         ///< commands of the log that nothing in it explains
  std::optional<ReplayDifference> first;
};

/// Feeds the measurements of a lock-step run through the law and compares every command. Set-up.
/// Errors: InputError if gains and log are not of one number of legs, or a measurement is missing.
ReplayResult replay_lock_step(const ReplayLog& log, const controller::Gains& gains);

/// Takes every loop of a wall-clock run up at its first checkpoint and goes through its records;
/// after a gap it goes on at the next checkpoint. Compares what is recorded of the command and of
/// the state, the memory at every checkpoint on the way, and the commands on the bus if the log has
/// them. Set-up. Errors: InputError if gains or checkpoints do not fit.
ReplayResult replay_wall_clock(const ReplayLog& log, const controller::Gains& gains,
                               const controller::Policy& policy);

}  // namespace stillframe::tools
