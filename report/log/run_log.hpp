#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "report/log/channel_count.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "stillframe_msgs/timing_t.hpp"

namespace stillframe::report {

/// One run as an LCM log holds it: a row a sample, in increasing seq, a column a channel. Set-up.
struct RunLog {
  stillframe_msgs::run_info_t info;

  std::vector<std::int64_t> seq;  ///< n, of each measurement
  Eigen::VectorXd time_s;         ///< n, s of plant time
  Eigen::MatrixXd
      floor_acceleration;  ///< n x n_floor, m/s^2, held over the interval ending at the sample
  Eigen::MatrixXd sigma;   ///< n x n_legs, N
  Eigen::MatrixXd applied_force;       ///< n x n_legs, N
  Eigen::MatrixXd frame_acceleration;  ///< n x n_frame, m/s^2

  std::vector<std::int64_t> command_seq;  ///< n_c, of the measurement that each command answers
  Eigen::MatrixXd command_force;          ///< n_c x n_legs, N
  std::int64_t n_saturated = 0;           ///< commands in which a force was limited

  ChannelCount measurements;  ///< gaps are counted up to info.n_samples where that is positive
  ChannelCount commands;      ///< gaps are counted between the first and the last command only

  std::optional<stillframe_msgs::timing_t> plant_timing;
  std::optional<stillframe_msgs::timing_t> controller_timing;

  double log_duration_s = 0;      ///< by the logger's clock, first to last measurement
  std::int64_t n_damaged = 0;     ///< events that could not be read or decoded
  std::int64_t unread_bytes = 0;  ///< at the end of a truncated file
};

/// Reads one run from an LCM log; channels of others are ignored.
/// run_id chooses the run; without it the log must hold exactly one. A truncated or damaged log
/// gives what was readable, and n_damaged and unread_bytes say that something was not. Errors:
/// InputError for a missing file, no run_info, several runs and no choice, run_info without
/// measurements, sizes that do not fit run_info, two different messages with one seq.
RunLog read_run_log(const std::filesystem::path& path,
                    std::optional<std::int64_t> run_id = std::nullopt);

}  // namespace stillframe::report
