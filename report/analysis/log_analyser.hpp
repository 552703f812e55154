#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/linear/multisine_plan.hpp"
#include "report/analysis/duration_histogram.hpp"
#include "report/analysis/level_track.hpp"
#include "report/analysis/response_analyser.hpp"
#include "report/analysis/signal_analyser.hpp"
#include "report/log/log_scan.hpp"

namespace stillframe::report {

/// A direction in which what moves below is compared with what moves above, by names of
/// run_info_t.frame_names.
struct AxisPlan {
  std::string name, floor, frame;
};

/// What is looked for in a log.
struct AnalysisPlan {
  std::vector<AxisPlan> axes;
  /// From the floor inputs to the first n_outputs frame accelerations; none: no matrix is sought.
  Eigen::Index n_outputs = 0;
  std::optional<MultisinePlan> multisine;  ///< that moved the floor, if one did
  std::vector<double> frequencies_hz;      ///< of broadband identification
  double segment_s = 64;                   ///< of broadband identification
};

/// One direction over a run.
struct AxisAnalysis {
  std::string name;
  SignalAnalysis floor, frame;
  std::vector<Shock> shocks;  ///< none are sought on a multisine floor
};

/// Everything that one log tells.
struct LogAnalysis {
  LogScan scan;
  std::vector<AxisAnalysis> axes;
  std::vector<LegAnalysis> legs;
  std::optional<IdentifiedResponse> matrix;       ///< all floor inputs to the outputs
  std::optional<IdentifiedResponse> axis_matrix;  ///< floors to frames of all axes
  DurationHistogram wake_up, compute;             ///< wall-clock runs, of the controller
};

/// Reads one run from a log in one pass. plan_of is asked once, when run_info is there. Errors: as
/// scan_log, and InputError for an axis of a name that the run has not.
LogAnalysis analyse_log(
    const std::filesystem::path& path, const ScanSettings& settings,
    const std::function<AnalysisPlan(const stillframe_msgs::run_info_t&)>& plan_of);

}  // namespace stillframe::report
