#include "tools/run/judge.hpp"

#include <algorithm>
#include <numbers>
#include <variant>

#include "core/frequency_response.hpp"
#include "core/yaml/input_error.hpp"
#include "report/identification/comparison.hpp"
#include "report/identification/identification.hpp"
#include "report/plots/plots.hpp"
#include "report/spectra/spectra.hpp"

namespace stillframe::tools {

namespace {

/// What the issue of a measured loop has to meet: measured singular values within this of the exact
/// prediction.
constexpr double allowed_db = 0.2;

std::vector<double> plot_frequencies(double sample_rate_hz) {
  const Eigen::VectorXd grid =
      logarithmic_frequencies(0.5, std::min(200.0, 0.45 * sample_rate_hz), 600);
  return {grid.begin(), grid.end()};
}

class Judge {
 public:
  Judge(const LoopDesign& design, const floor::FloorSpec& floor, const RunLogs& logs,
        const RunDirectory& directory)
      : design_(design), floor_(floor), logs_(logs), directory_(directory) {}

  report::Verdict run() {
    for (const auto* log : {&logs_.passive, &logs_.active}) {
      if (!*log) continue;
      verdict_.runs.push_back(report::summarise(**log));
      for (auto& timing : report::timing_of(**log)) verdict_.timing.push_back(timing);
    }
    predict();
    if (const auto* plan = std::get_if<MultisinePlan>(&floor_.kind)) {
      identify(*plan);
    } else {
      compare_motion();
    }
    report::plot_singular_values(picture_, directory_ / "singular_values.png");
    return verdict_;
  }

 private:
  void predict() {
    picture_.title = design_.scene.title;
    picture_.frequencies_hz = plot_frequencies(design_.gains.sample_rate_hz);
    picture_.open_predicted =
        report::predicted_singular_values(design_.open, picture_.frequencies_hz);
    picture_.closed_predicted =
        report::predicted_singular_values(design_.closed, picture_.frequencies_hz);
    picture_.target_frequency_hz = design_.scene.controller->lowest_target_hz();
    picture_.target_damping = design_.scene.controller->damping_ratio.front();
  }

  report::FrequencyResponse response(const MultisinePlan& plan, const report::RunLog& log) const {
    if (log.measurements.n_lost > 0) {
      throw InputError("the log has lost " + std::to_string(log.measurements.n_lost) +
                       " measurements; nothing can be identified from it");
    }
    return report::identify(plan, log.floor_acceleration,
                            log.frame_acceleration.leftCols(design_.loop.n_y));
  }

  void identify(const MultisinePlan& plan) {
    if (!logs_.passive || !logs_.active) return;
    const auto open = response(plan, *logs_.passive), closed = response(plan, *logs_.active);
    const auto open_error = report::compare(open, design_.open);
    const auto closed_error = report::compare(closed, design_.closed);
    const double above_hz = 2 * design_.scene.controller->lowest_target_hz();
    const auto reduction =
        report::check_reduction(open, closed, design_.open, design_.closed, above_hz);
    verdict_.identification =
        report::summarise(open_error, closed_error, reduction, plan.frequencies_hz, above_hz,
                          report::default_floor_db, allowed_db);
    picture_.open_measured = {open.frequencies_hz, open.singular_values};
    picture_.closed_measured = {closed.frequencies_hz, closed.singular_values};
    report::plot_differences({.title = design_.scene.title,
                              .frequencies_hz = plan.frequencies_hz,
                              .open_db = open_error.difference_db,
                              .closed_db = closed_error.difference_db,
                              .allowed_db = allowed_db},
                             directory_ / "prediction_error.png");
  }

  Eigen::VectorXd signal(const std::optional<report::RunLog>& log, const std::string& name) const {
    if (!log) return {};
    const auto& names = log->info.frame_names;
    return log->frame_acceleration.col(std::find(names.begin(), names.end(), name) - names.begin());
  }

  void compare_motion() {
    const double rate = design_.gains.sample_rate_hz;
    report::HistoryPlot histories{.title = design_.scene.title, .sample_rate_hz = rate, .axes = {}};
    report::OctavePlot octaves{.title = design_.scene.title, .axes = {}};
    const auto bands = [&](const Eigen::VectorXd& a) -> Eigen::VectorXd {
      if (a.size() == 0) return {};
      return report::third_octave_velocity(
          report::welch(a, rate, report::default_segment_length(a.size(), rate)));
    };
    for (const SceneComparison& comparison : design_.scene.comparisons) {
      const auto& any = logs_.active ? logs_.active : logs_.passive;
      const Eigen::VectorXd floor = signal(any, comparison.floor);
      const Eigen::VectorXd passive = signal(logs_.passive, comparison.frame);
      const Eigen::VectorXd active = signal(logs_.active, comparison.frame);
      report::AxisLevels levels{.axis = comparison.name, .floor = {}, .passive = {}, .active = {}};
      levels.floor = report::motion_level(floor, rate);
      if (passive.size() > 0) levels.passive = report::motion_level(passive, rate);
      if (active.size() > 0) levels.active = report::motion_level(active, rate);
      verdict_.axes.push_back(levels);
      histories.axes.push_back({comparison.name, floor, passive, active});
      octaves.axes.push_back({comparison.name, bands(floor), bands(passive), bands(active)});
    }
    if (histories.axes.empty()) return;
    report::plot_histories(histories, directory_ / "accelerations.png");
    report::plot_third_octaves(octaves, directory_ / "third_octaves.png");
  }

  const LoopDesign& design_;
  const floor::FloorSpec& floor_;
  const RunLogs& logs_;
  const RunDirectory& directory_;
  report::Verdict verdict_;
  report::SingularValuePlot picture_;
};

}  // namespace

report::Verdict judge(const LoopDesign& design, const floor::FloorSpec& floor, const RunLogs& logs,
                      const RunDirectory& directory) {
  return Judge(design, floor, logs, directory).run();
}

}  // namespace stillframe::tools
