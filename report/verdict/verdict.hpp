#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace stillframe::report {

struct RunLog;
struct PredictionError;
struct ReductionCheck;

/// What ran, and how whole its log is.
struct RunSummary {
  std::string scene_name, scene_hash, program_version;
  std::string mode;  ///< lock_step or wall_clock
  std::string loop;  ///< active or passive
  double sample_rate_hz = 0;
  double delay_samples = 0;
  std::int64_t n_samples = 0;  ///< in the log
  std::int64_t n_lost = 0;     ///< measurements that the log should hold and does not
  std::int64_t n_duplicates = 0;
  std::int64_t n_commands = 0;
  std::int64_t n_saturated = 0;  ///< commands in which a force was limited
  std::int64_t n_damaged = 0, unread_bytes = 0;
  double real_time_factor = 0;  ///< plant time over wall time; 0 if neither clock tells
};

/// One process's own account of its deadlines.
struct TimingSummary {
  std::string loop;    ///< of the run
  std::string source;  ///< plant or controller
  std::int64_t n_periods = 0, n_late = 0, n_lost = 0, n_duplicates = 0, n_listened = 0;
  double worst_wake_up_us = 0, worst_compute_us = 0;
};

/// Measured against predicted frequency responses.
struct IdentificationSummary {
  int n_frequencies = 0;
  double lowest_hz = 0, highest_hz = 0;
  double floor_db = 0;    ///< values predicted below it are not compared
  double allowed_db = 0;  ///< on each deviation below
  double open_largest_db = 0, open_at_hz = 0;
  double closed_largest_db = 0, closed_at_hz = 0;
  double reduction_above_hz = 0;  ///< the reduction is judged above this
  int n_reduction_frequencies = 0, n_closed_below_open = 0;
  double reduction_largest_error_db = 0;

  /// All deviations allowed, and the closed loop below the open one wherever it is judged.
  bool pass() const;
};

/// One signal's numbers in one direction.
struct MotionLevel {
  double rms_acceleration = 0;       ///< m/s^2, 1-80 Hz
  double largest_band_velocity = 0;  ///< m/s rms, largest one-third-octave band, 1-80 Hz
  double largest_band_hz = 0;        ///< nominal centre of that band
  std::string vibration_class;       ///< VC-A ... VC-G, or above VC-A
};
struct AxisLevels {
  std::string axis;
  std::optional<MotionLevel> floor, passive, active;
};

/// Everything that a run directory states. Left-out parts do not appear.
struct Verdict {
  std::vector<RunSummary> runs;
  std::vector<TimingSummary> timing;
  std::optional<IdentificationSummary> identification;
  std::vector<AxisLevels> axes;

  /// No sample lost, nothing damaged, and the identification, if there is one, passes.
  bool pass() const;
};

/// Fills the summaries from what was read and computed.
RunSummary summarise(const RunLog& log);
std::vector<TimingSummary> timing_of(const RunLog& log);
IdentificationSummary summarise(const PredictionError& open, const PredictionError& closed,
                                const ReductionCheck& reduction,
                                const std::vector<double>& frequencies_hz,
                                double reduction_above_hz, double floor_db, double allowed_db);

/// Levels of an acceleration signal, m/s^2, by welch() with default_segment_length().
MotionLevel motion_level(const Eigen::VectorXd& acceleration, double sample_rate_hz);

/// The verdict as JSON. Numbers read back to the same bits (up to 17 significant digits), a number
/// that is not finite is null. Keys:
///   format 1, pass
///   runs[]: scene_name scene_hash program_version mode loop sample_rate_hz delay_samples n_samples
///   n_lost
///     n_duplicates n_commands n_saturated n_damaged unread_bytes real_time_factor (null if
///     unknown)
///   timing[]: loop source n_periods n_late n_lost n_duplicates n_listened worst_wake_up_us
///   worst_compute_us identification (if any): pass n_frequencies lowest_hz highest_hz floor_db
///   allowed_db open_largest_db
///     open_at_hz closed_largest_db closed_at_hz reduction_above_hz n_reduction_frequencies
///     n_closed_below_open reduction_largest_error_db
///   axes[]: axis, then floor, passive, active (those there are): rms_acceleration (m/s^2, 1-80 Hz)
///     largest_band_velocity (m/s rms) largest_band_hz vibration_class; ratio_active_to_passive and
///     ratio_active_to_floor, each with rms_acceleration and largest_band_velocity
std::string to_json(const Verdict& verdict);

/// The verdict as a page of text with aligned tables, units in the headers.
std::string to_text(const Verdict& verdict);

/// Writes to_json() to a file. Errors: InputError if that cannot be done.
void write_json(const Verdict& verdict, const std::filesystem::path& path);

}  // namespace stillframe::report
