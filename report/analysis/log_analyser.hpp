#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/systems/multisine_plan.hpp"
#include "core/systems/sampled_loop.hpp"
#include "report/analysis/axis_signals.hpp"
#include "report/analysis/duration_histogram.hpp"
#include "report/analysis/floor_samples.hpp"
#include "report/analysis/level_track.hpp"
#include "report/analysis/loop_response.hpp"
#include "report/analysis/response_analyser.hpp"
#include "report/analysis/signal_analyser.hpp"
#include "report/log/log_scan.hpp"

namespace stillframe::report {

/// The loop that ran, as its model has it.
struct RunModel {
  /// From the floor inputs to the first n_outputs frame accelerations and then the outputs of
  /// AnalysisPlan::axis_signals.
  SampledLoop loop;
  std::optional<LateLoop> late = {};  ///< the same, of one that was not closed from the beginning
  /// T at the frequencies of broadband identification: of the outputs, and of the axes' signals;
  /// none if the floors of the axes do not tell how the floor moves.
  std::vector<Eigen::MatrixXcd> matrix, axes;
  /// The inputs of the axes' signals and then their dependent floors, as the floor inputs move
  /// them, so many x floor inputs, if axes are there.
  Eigen::MatrixXd floors = {};
  /// What the floor inputs would be on a floor that does not turn and moves as they say at best;
  /// and of each axis, whether its frame is moved by parts of the floor that no input measures, so
  /// that the loop has them move as such a floor. Empty: no axis is.
  Eigen::MatrixXd rigid = {};
  std::vector<bool> leans_on_rigid = {};
  /// Such an axis is not known at all: the floor's block moves single inputs beside its axes, and
  /// what of the inputs is which no signal tells.
  bool moved_apart = false;
};

/// What is looked for in a log.
struct AnalysisPlan {
  std::vector<AxisPlan> axes;
  /// Motion is judged from this sample on, and before that one; the rest is in envelopes only.
  std::int64_t judged_from = 0, judged_until = Takeover::never;
  std::vector<std::string> frames = {};  ///< accelerations that are sought beside those of axes
  AxisSignals axis_signals = {};         ///< of the axes; none: those by name
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
  /// Of the forces that act besides the floor, to every frame acceleration; none: there are none,
  /// or they are not known.
  std::optional<ForceModel> forces = {};
  std::string forces_unknown = {};  ///< why they are not, if there are any
};

/// What forces besides the floor do to a frame, (m/s^2)^2 / Hz.
struct ForcesPart {
  Psd by_forces;    ///< what the model makes of them
  Psd undisturbed;  ///< the frame's acceleration less that
};

/// One direction over a run.
struct AxisAnalysis {
  std::string name;
  SignalAnalysis floor, frame;
  /// Of the frame's acceleration less what the model makes of the floor, (m/s^2)^2 / Hz.
  std::optional<Psd> unexplained;
  std::string unexplained_missing;   ///< why it is not there; empty: it is
  std::optional<ForcesPart> forces;  ///< if there are any and they are known
  std::vector<Shock> shocks;         ///< none are sought on a multisine floor
};

/// An acceleration by itself.
struct FrameAnalysis {
  std::string name;
  SignalAnalysis motion;
  std::optional<ForcesPart> forces;  ///< as of an axis
};

/// Everything that one log tells.
struct LogAnalysis {
  LogScan scan;
  FloorSamples floor;
  std::vector<AxisAnalysis> axes;
  std::vector<FrameAnalysis> frames;
  AxisSignals axis_signals;    ///< of axis_matrix
  std::string forces_unknown;  ///< why no axis has its part of forces that act; empty: none do
  std::vector<LegAnalysis> legs;
  std::optional<IdentifiedResponse> matrix;       ///< all floor inputs to the outputs
  std::optional<IdentifiedResponse> axis_matrix;  ///< between axis_signals
  std::int64_t judged_from = 0;                   ///< of the plan
  std::int64_t judged_until = 0;                  ///< of the plan, or of the samples that there are
  std::int64_t n_judged = 0;                      ///< samples between these two
  DurationHistogram wake_up, compute;             ///< wall-clock runs, of the controller
  /// Wall-clock runs: periods of the controller, those whose measurement it rejected, and those in
  /// which it sent a command.
  std::int64_t n_periods = 0, n_discarded = 0, n_commanded = 0;
};

/// Reads one run from a log in one pass. plan_of is asked once, when run_info is there. Errors: as
/// scan_log, and InputError for an axis or a frame of a name that the run has not.
LogAnalysis analyse_log(
    const std::filesystem::path& path, const ScanSettings& settings,
    const std::function<AnalysisPlan(const stillframe_msgs::run_info_t&)>& plan_of);

}  // namespace stillframe::report
