#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "judge/recorded_run.hpp"
#include "judge/response_prediction.hpp"
#include "report/analysis/log_analyser.hpp"
#include "report/identification/comparison.hpp"

namespace stillframe::judge {

/// Measured singular values against both predictions.
struct PredictionErrors {
  Eigen::MatrixXd sampled_values, continuous_values;  ///< n_f x n_s, predicted
  report::PredictionError sampled, continuous;
};

/// An identified response beside what the log's own model has for it.
struct JudgedResponse {
  report::IdentifiedResponse measured;
  report::Bands bands = {};  ///< 95 %, of its singular values, if it is there
  std::optional<PredictedResponse> predicted =
      {};                                       ///< at the same frequencies, of the loop that ran
  std::string unpredicted = {};                 ///< why there is none
  std::optional<PredictionErrors> errors = {};  ///< where both are there
};

/// One log, taken apart and set against its own model.
struct RunAnalysis {
  std::filesystem::path log;
  report::LogAnalysis data;  ///< its responses have gone to the two below
  RecordedRun run;
  std::optional<JudgedResponse> matrix;  ///< floor inputs to the scene's outputs
  std::optional<JudgedResponse> axes;    ///< floors to frames of the scene's comparisons

  bool active() const { return data.scan.info.loop == "active"; }
};

struct RunAnalyses;

/// One direction with the analyses of those loops that share a floor; at least one is there.
struct AxisPair {
  std::string name;
  const report::AxisAnalysis *passive = nullptr, *active = nullptr;

  /// What moved below both.
  const report::SignalAnalysis& floor() const { return (active ? active : passive)->floor; }
  /// The name, with the loop where the other one stood on another floor.
  std::string title(const RunAnalyses& runs) const;
};

/// A log with zero commands and one with the law, or one of them.
struct RunAnalyses {
  std::optional<RunAnalysis> passive, active;

  const RunAnalysis& any() const { return active ? *active : *passive; }
  /// Whether both loops stood on the same floor for the same time: only then is the motion of the
  /// one set against that of the other. True with one run.
  bool same_floor() const;
  /// Directions of the runs, those of both loops together where the floor is the same, else the
  /// passive ones before the active ones.
  std::vector<AxisPair> axes() const;
  /// Puts a run where it belongs. Errors: InputError if there is one of its kind already, or if it
  /// is of another scene or rate than the other.
  void add(RunAnalysis run);
};

/// How a log is analysed.
struct AnalysisSettings {
  std::optional<std::int64_t> run_id;
  std::optional<int> plant = {};  ///< as in report::ScanSettings
  double segment_s = 64;          ///< of broadband identification
  report::ComparisonRule comparison = {};
  std::function<void(double)> progress = {};  ///< share of the file, 0 to 1
};

/// A log by itself. Errors: as scan_log.
RunAnalysis analyse_run(const std::filesystem::path& log, const AnalysisSettings& settings = {});

struct LogToAnalyse {
  std::filesystem::path log;
  AnalysisSettings settings = {};
};

/// One or two logs of a scene. A passive run is judged from the same sample on as the active one
/// beside it if both are said to have had the same floor: what shook both frames while the loop was
/// not closed shows nothing of it. Errors: as analyse_run and RunAnalyses::add.
RunAnalyses analyse_runs(std::vector<LogToAnalyse> logs);

}  // namespace stillframe::judge
