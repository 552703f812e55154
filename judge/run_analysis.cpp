#include "judge/run_analysis.hpp"

#include <algorithm>

#include "core/errors/input_error.hpp"
#include "report/log/run_search.hpp"

namespace stillframe::judge {

namespace {

using stillframe_msgs::run_info_t;

std::optional<JudgedResponse> judged(std::optional<report::IdentifiedResponse>& measured,
                                     const RecordedRun& run, bool active,
                                     const report::ComparisonRule& rule) {
  if (!measured) return std::nullopt;
  JudgedResponse result{.measured = std::move(*measured)};
  measured.reset();
  const auto& response = result.measured.response;
  if (response) result.bands = report::singular_value_bands(*response, 0.95);
  if (!run.design) {
    result.unpredicted = run.unreadable;
    return result;
  }
  if (!response) return result;
  try {
    result.predicted = ResponsePrediction(*run.design, result.measured.signals, run.nodes)
                           .at(response->frequencies_hz, active);
    PredictionErrors errors;
    errors.sampled_values = report::singular_values(result.predicted->sampled);
    errors.continuous_values = report::singular_values(result.predicted->continuous);
    errors.sampled = report::compare(*response, result.bands, errors.sampled_values, rule);
    errors.continuous = report::compare(*response, result.bands, errors.continuous_values, rule);
    result.errors = std::move(errors);
  } catch (const std::exception& error) {
    result.unpredicted = error.what();
  }
  return result;
}

bool same_floor_said(const run_info_t& a, const run_info_t& b) {
  return a.floor_text == b.floor_text && a.n_samples == b.n_samples &&
         a.floor_names == b.floor_names && a.frame_names == b.frame_names;
}

/// Takes away what a log says of a loop that never held its frame: it is of another one.
void forget_loop(RunAnalysis& run) {
  const std::string why = "the loop never held the frame: " + run.run.hold->why;
  for (auto* response : {&run.data.matrix, &run.data.axis_matrix}) {
    if (!*response) continue;
    (*response)->response.reset();
    (*response)->missing = why;
  }
  for (report::AxisAnalysis& axis : run.data.axes) {
    axis.unexplained.reset();
    axis.unexplained_missing = why;
  }
  run.data.n_judged = 0;
}

/// active: that another run is set beside, if it is there.
RunAnalysis analyse_beside(const std::filesystem::path& log, const AnalysisSettings& settings,
                           const RunAnalysis* active) {
  RunAnalysis result;
  result.log = log;
  report::ScanSettings scan;
  scan.run_id = settings.run_id;
  scan.plant = settings.plant;
  scan.progress = settings.progress;
  result.data = report::analyse_log(log, scan, [&](const run_info_t& info) {
    result.run = recorded_run(info, log);
    report::AnalysisPlan plan = analysis_plan(result.run, info);
    plan.segment_s = settings.segment_s;
    if (active != nullptr && same_floor_said(info, active->data.scan.info)) {
      plan.judged_from = active->data.judged_from;
      plan.judged_until = active->data.judged_until;
    }
    return plan;
  });
  if (result.run.never_held()) forget_loop(result);
  result.matrix = judged(result.data.matrix, result.run, result.active(), settings.comparison);
  result.axes = judged(result.data.axis_matrix, result.run, result.active(), settings.comparison);
  return result;
}

}  // namespace

RunAnalysis analyse_run(const std::filesystem::path& log, const AnalysisSettings& settings) {
  return analyse_beside(log, settings, nullptr);
}

RunAnalyses analyse_runs(std::vector<LogToAnalyse> logs) {
  // Its takeover is to be known first.
  if (logs.size() > 1) {
    std::stable_partition(logs.begin(), logs.end(), [](const LogToAnalyse& one) {
      return report::find_run_info(one.log, one.settings.run_id, {}, {}).loop == "active";
    });
  }
  RunAnalyses runs;
  for (const LogToAnalyse& one : logs) {
    runs.add(analyse_beside(one.log, one.settings, runs.active ? &*runs.active : nullptr));
  }
  // Of the same words, and not the same samples: each is judged by itself.
  if (!runs.same_floor() &&
      runs.passive->data.n_judged < runs.passive->data.scan.measurements.n_received) {
    runs.passive = analyse_beside(logs.back().log, logs.back().settings, nullptr);
  }
  return runs;
}

std::string AxisPair::title(const RunAnalyses& runs) const {
  if (runs.same_floor()) return name;
  return name + (active != nullptr ? ", active run" : ", passive run");
}

bool RunAnalyses::same_floor() const {
  if (!passive || !active) return true;
  const auto &a = passive->data.scan.info, &b = active->data.scan.info;
  return same_floor_said(a, b) && passive->data.floor.agrees(active->data.floor);
}

std::vector<AxisPair> RunAnalyses::axes() const {
  std::vector<AxisPair> pairs;
  const bool together = same_floor();
  const auto place_of = [&](const std::string& name) -> AxisPair& {
    const auto found = std::find_if(pairs.begin(), pairs.end(), [&](const AxisPair& pair) {
      return together && pair.name == name;
    });
    return found != pairs.end() ? *found : pairs.emplace_back(AxisPair{.name = name});
  };
  if (passive) {
    for (const auto& axis : passive->data.axes) place_of(axis.name).passive = &axis;
  }
  if (active) {
    for (const auto& axis : active->data.axes) place_of(axis.name).active = &axis;
  }
  return pairs;
}

void RunAnalyses::add(RunAnalysis run) {
  auto& place = run.active() ? active : passive;
  const auto& other = run.active() ? passive : active;
  if (place) {
    throw InputError(run.log.string() + ": a second log of the " + run.data.scan.info.loop +
                     " loop, beside " + place->log.string());
  }
  if (other) {
    const auto &a = run.data.scan.info, &b = other->data.scan.info;
    if (a.scene_hash != b.scene_hash || a.sample_rate_hz != b.sample_rate_hz) {
      throw InputError(run.log.string() + ": scene " + a.scene_hash + " at " +
                       std::to_string(a.sample_rate_hz) + " Hz cannot be set beside scene " +
                       b.scene_hash + " at " + std::to_string(b.sample_rate_hz) + " Hz of " +
                       other->log.string());
    }
  }
  place = std::move(run);
}

}  // namespace stillframe::judge
