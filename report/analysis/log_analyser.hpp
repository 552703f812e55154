#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/linear/multisine_plan.hpp"
#include "core/linear/sampled_loop.hpp"
#include "report/analysis/axis_signals.hpp"
#include "report/analysis/duration_histogram.hpp"
#include "report/analysis/floor_samples.hpp"
#include "report/analysis/level_track.hpp"
#include "report/analysis/response_analyser.hpp"
#include "report/analysis/signal_analyser.hpp"
#include "report/log/log_scan.hpp"

namespace stillframe::report {

/// The loop that ran, as its model has it.
struct RunModel {
  /// From the floor inputs to the first n_outputs frame accelerations and then the outputs of
  /// AnalysisPlan::axis_signals.
  SampledLoop loop;
  /// T at the frequencies of broadband identification: of the outputs, and of the axes' signals;
  /// none if the floors of the axes do not tell how the floor moves.
  std::vector<Eigen::MatrixXcd> matrix, axes;
  /// The inputs of the axes' signals and then their dependent floors, as the floor inputs move
  /// them, so many x floor inputs, if axes are there.
  Eigen::MatrixXd floors = {};
};

/// What is looked for in a log.
struct AnalysisPlan {
  std::vector<AxisPlan> axes;
  AxisSignals axis_signals = {};  ///< of the axes; none: those by name
  /// From the floor inputs to the first n_outputs frame accelerations; none: no matrix is sought.
  Eigen::Index n_outputs = 0;
  std::optional<MultisinePlan> multisine;  ///< that moved the floor, if one did
  std::vector<double> frequencies_hz;      ///< of broadband identification
  double segment_s = 64;                   ///< of broadband identification
  double lowest_hz = 1;                    ///< of the ranges that levels are judged in
  /// unit / sqrt(Hz), of the sensors of the floor inputs, if it is known.
  std::optional<double> floor_noise = {};
  std::optional<RunModel> model = {};
  std::string unmodelled = {};  ///< why there is none
};

/// One direction over a run.
struct AxisAnalysis {
  std::string name;
  SignalAnalysis floor, frame;
  /// Of the frame's acceleration less what the model makes of the floor, (m/s^2)^2 / Hz.
  std::optional<Psd> unexplained;
  std::vector<Shock> shocks;  ///< none are sought on a multisine floor
};

/// Everything that one log tells.
struct LogAnalysis {
  LogScan scan;
  FloorSamples floor;
  std::vector<AxisAnalysis> axes;
  AxisSignals axis_signals;  ///< of axis_matrix
  std::vector<LegAnalysis> legs;
  std::string unexplained_missing;                ///< why no axis has it
  std::optional<IdentifiedResponse> matrix;       ///< all floor inputs to the outputs
  std::optional<IdentifiedResponse> axis_matrix;  ///< between axis_signals
  DurationHistogram wake_up, compute;             ///< wall-clock runs, of the controller
  /// Wall-clock runs: periods of the controller, those whose measurement it rejected, and those in
  /// which it sent a command.
  std::int64_t n_periods = 0, n_discarded = 0, n_commanded = 0;
};

/// Reads one run from a log in one pass. plan_of is asked once, when run_info is there. Errors: as
/// scan_log, and InputError for an axis of a name that the run has not.
LogAnalysis analyse_log(
    const std::filesystem::path& path, const ScanSettings& settings,
    const std::function<AnalysisPlan(const stillframe_msgs::run_info_t&)>& plan_of);

}  // namespace stillframe::report
