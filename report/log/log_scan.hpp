#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "report/log/channel_count.hpp"
#include "report/log/plant_parts.hpp"
#include "report/log/sample_check.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "stillframe_msgs/loop_record_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "stillframe_msgs/timing_t.hpp"

namespace stillframe::report {

/// Consecutive samples of one run without a gap, a row a sample. What the floor, the legs and the
/// frame did is in the columns of run_info_t's names.
struct SampleBlock {
  std::int64_t first_seq = 0;          ///< k of the first row
  Eigen::VectorXd time_s;              ///< n, s of plant time
  Eigen::MatrixXd floor_acceleration;  ///< n x n_floor, m/s^2, held over the sample before
  Eigen::MatrixXd sigma;               ///< n x n_legs, N
  Eigen::MatrixXd applied_force;       ///< n x n_legs, N
  Eigen::MatrixXd frame_acceleration;  ///< n x n_frame, m/s^2
  Eigen::MatrixXd command_force;  ///< n x n_legs, N, the answer to the row's measurement; NaN: none
  Eigen::MatrixXd excitation;     ///< n x n_legs, N, what that has beside the law's force

  Eigen::Index n_samples() const { return time_s.size(); }
};

/// Takes one run from a log, part by part, in the order of seq. Set-up.
class LogVisitor {
 public:
  virtual ~LogVisitor() = default;
  /// Once, before anything else.
  virtual void begin(const stillframe_msgs::run_info_t& /*info*/) {}
  /// A block follows the one before it without a gap unless its first_seq says otherwise.
  virtual void samples(const SampleBlock& /*block*/) {}
  /// One period of a wall-clock controller, in the order of the log.
  virtual void period(const stillframe_msgs::loop_record_t& /*record*/) {}
};

/// How a log is read.
struct ScanSettings {
  std::optional<std::int64_t> run_id;  ///< without it the log must hold exactly one run
  std::optional<int> plant;            ///< of LogScan::plants, from 1; without it choose_plant's
  Eigen::Index block_samples = 4096;   ///< the most rows of a block
  /// A message this much older than the newest one is no longer put in its place but counted in
  /// n_too_late; memory grows with it.
  std::int64_t reorder_samples = 4096;
  std::function<void(double)> progress;  ///< the share of the file that is read, 0 to 1
};

/// What a log holds beside the samples.
struct LogScan {
  stillframe_msgs::run_info_t info;
  std::vector<PlantPart> plants;  ///< of the run, in the order in which they ended
  std::size_t plant = 0;          ///< the one of them that all here is of
  ChannelCount measurements, commands;
  std::int64_t n_too_late = 0;   ///< messages that came too late to be put in their place
  std::int64_t n_saturated = 0;  ///< commands in which a force was limited
  SampleFaults faults;
  std::optional<stillframe_msgs::timing_t> plant_timing;
  std::optional<stillframe_msgs::timing_t> controller_timing;  ///< none if there are several plants
  std::optional<stillframe_msgs::controller_status_t> last_status;
  std::int64_t first_us = 0;  ///< since the UNIX epoch, by the logger's clock, when the run began
  double log_duration_s = 0;  ///< by the logger's clock, its steps taken out
  std::int64_t n_clock_steps =
      0;  ///< where the logger's clock went back, or ahead by over a minute
  double largest_clock_step_s = 0;
  std::int64_t n_damaged = 0;      ///< places where the file could not be read
  std::int64_t n_undecodable = 0;  ///< events on our channels that are not whole messages of theirs
  std::int64_t n_other_version = 0;  ///< of these: whole messages of another version of the type
  std::int64_t unread_bytes = 0;     ///< at the end of a truncated file
  std::map<std::string, std::int64_t> foreign;  ///< events of channels that are not ours, at most
                                                ///< 100 names, the rest under ""
};

/// Reads one run of an LCM log, as one plant measured it, from front to back in bounded memory and
/// hands it to a visitor.
/// A truncated or damaged log gives what was readable. Errors: InputError for a missing file, no
/// run_info, several runs and no choice, a run without measurements, sizes that do not fit
/// run_info, another format_version, two different messages with one seq, a plant that is not
/// there.
LogScan scan_log(const std::filesystem::path& path, const ScanSettings& settings,
                 LogVisitor& visitor);

/// What a reader has to know of a run that several plants measured, or nothing (plant_parts.hpp).
inline std::string plants_in_words(const LogScan& scan) {
  return plants_in_words(scan.plants, scan.plant, scan.info.run_id);
}

}  // namespace stillframe::report
