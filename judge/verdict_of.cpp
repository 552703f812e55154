#include "judge/verdict_of.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors/formatted.hpp"
#include "judge/loop_between.hpp"
#include "judge/loop_comparison.hpp"
#include "judge/loop_target.hpp"
#include "judge/multisine_motion.hpp"
#include "judge/prediction_checks.hpp"
#include "judge/resting_channels.hpp"
#include "judge/unmeasured_floor.hpp"
#include "report/analysis/summaries.hpp"
#include "report/verdict/acceptance.hpp"
#include "report/verdict/motion_level.hpp"

namespace stillframe::judge {

namespace {

/// Whether two responses have the same compared values, as those of one floor input and of the one
/// axis above it have: to a hundredth of what a prediction is known to, which no noise leaves of
/// channels that were measured twice.
bool repeats(const JudgedResponse& one, const JudgedResponse& other) {
  if (!one.errors || !other.errors) return false;
  const Eigen::MatrixXd &a = one.errors->sampled.difference_db,
                        &b = other.errors->sampled.difference_db;
  if (a.rows() != b.rows() || a.cols() != b.cols()) return false;
  constexpr double alike_db = 1e-3;
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    const double x = a.reshaped()(i), y = b.reshaped()(i);
    if (std::isnan(x) != std::isnan(y) || std::abs(x - y) > alike_db) return false;
  }
  return true;
}

report::ResponseSummary summary_of(const JudgedResponse& response, const std::string& loop,
                                   bool of_axes) {
  const report::IdentifiedResponse& measured = response.measured;
  report::ResponseSummary summary;
  summary.loop = loop;
  const auto many = [](std::size_t n, const char* what) {
    return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
  };
  summary.what = many(measured.signals.inputs.size(), of_axes ? "floor" : "input") + " to " +
                 many(measured.signals.outputs.size(), of_axes ? "frame" : "output");
  summary.method = measured.method;
  summary.missing = measured.missing.empty() ? response.unpredicted : measured.missing;
  summary.n_segments = measured.n_segments;
  summary.n_filled = measured.n_filled;
  summary.n_left_out = measured.n_left_out;
  summary.resolution_hz = measured.resolution_hz;
  if (measured.response) {
    summary.n_frequencies = static_cast<int>(measured.response->n_frequencies());
  }
  if (const auto& errors = response.errors) {
    summary.n_compared = static_cast<int>(errors->sampled.n_compared);
    summary.sampled_largest_db = errors->sampled.largest_db;
    summary.sampled_at_hz = errors->sampled.at_frequency_hz;
    summary.beyond_db = errors->sampled.beyond_db;
    summary.broadly_beyond_db = report::broadly_beyond_db(errors->sampled);
    summary.tolerance_db = errors->sampled.tolerance_db;
    if (summary.n_compared == 0 && summary.missing.empty()) {
      summary.missing = "no singular value is known to 1 dB, so that none is compared";
    }
    summary.continuous_largest_db = errors->continuous.largest_db;
    summary.continuous_at_hz = errors->continuous.at_frequency_hz;
  }
  return summary;
}

void add_run(report::Verdict& verdict, const RunAnalysis& run) {
  const report::LogAnalysis& log = run.data;
  const std::string& loop = log.scan.info.loop;
  const auto append = [](auto& list, auto more) {
    for (auto& item : more) list.push_back(std::move(item));
  };
  verdict.runs.push_back(report::run_summary(log));
  verdict.runs.back().unreadable = run.run.unreadable;
  if (run.run.hold) {
    verdict.runs.back().fault = run.run.hold->fault;
    (run.run.hold->ever ? verdict.runs.back().let_go : verdict.runs.back().never_held) =
        run.run.hold->why;
  }
  verdict.runs.back().resting_channels = resting_channels(run);
  verdict.runs.back().resting_forces = resting_forces(run);
  append(verdict.timing, report::timing_summaries(log));
  append(verdict.shocks, report::shock_summaries(log));
  std::optional<double> limit;
  if (run.run.design) limit = run.run.design->gains.force_limit_n;
  append(verdict.effort, report::effort_summaries(log, limit));
  for (const auto* response : {&run.matrix, &run.axes}) {
    if (!*response) continue;
    const bool of_axes = response == &run.axes;
    report::ResponseSummary summary = summary_of(**response, loop, of_axes);
    summary.repeats = of_axes && run.matrix && repeats(*run.axes, *run.matrix);
    if (run.run.design) {
      const UnmeasuredFloor floor =
          unmeasured_floor(*run.run.design, **response, run.active(), of_axes, run.run.nodes);
      summary.n_unmeasured = floor.n_directions;
      summary.unmeasured_largest_db = floor.largest_db;
      summary.unmeasured_broadly_db = floor.broadly_db;
    }
    verdict.responses.push_back(std::move(summary));
  }
  append(verdict.noise, report::noise_summaries(log));
  if (run.axes && run.axes->measured.response) {
    append(verdict.transmissibility, report::transmissibilities(log, *run.axes->measured.response));
  }
}

/// Why an axis says nothing: a signal of it that rests where it should not.
std::string resting_in(const RunAnalyses& runs, const report::Verdict& verdict,
                       const AxisPair& pair) {
  for (const auto* run : {&runs.passive, &runs.active}) {
    if (!*run || !(*run)->run.design) continue;
    const std::string& loop = (*run)->data.scan.info.loop;
    if ((loop == "active" ? pair.active : pair.passive) == nullptr) continue;
    for (const SceneComparison& comparison : (*run)->run.design->scene.comparisons) {
      if (comparison.name != pair.name) continue;
      for (const report::RunSummary& summary : verdict.runs) {
        if (summary.loop != loop) continue;
        for (const report::RestingChannel& channel : summary.resting_channels) {
          if (channel.name != comparison.floor && channel.name != comparison.frame) continue;
          return channel.text() + " never changes in the log of the " + loop +
                 " run though what moves the frame does";
        }
      }
    }
  }
  return {};
}

void add_axes(report::Verdict& verdict, const RunAnalyses& runs, const SceneAcceptance& accept) {
  const auto frame_of = [](const report::AxisAnalysis* axis) {
    return axis != nullptr ? &axis->frame : nullptr;
  };
  for (const AxisPair& pair : runs.axes()) {
    const bool held = runs.active && !runs.active->run.never_held();
    if (!held && pair.passive == nullptr) continue;
    const auto *passive = frame_of(pair.passive), *active = held ? frame_of(pair.active) : nullptr;
    const bool known = pair.active != nullptr && pair.active->forces;
    add_levels(accept, pair.name, &pair.floor(), passive, active,
               known ? &*pair.active->forces : nullptr, verdict);
    verdict.axes.back().resting = resting_in(runs, verdict, pair);
  }
}

/// What no check fails by default and a customer would want to hear.
void add_warnings(report::Verdict& verdict) {
  for (const report::AxisLevels& axis : verdict.axes) {
    std::string worse = report::worse_over_all(axis);
    if (!worse.empty()) verdict.warnings.push_back(std::move(worse));
  }
  const std::string worse = report::worse_by_class(verdict.axes);
  if (!worse.empty()) {
    verdict.warnings.push_back("By vibration class the active frame is worse than the floor in " +
                               worse + ".");
  }
  for (const report::ResponseSummary& response : verdict.responses) {
    if (response.repeats || response.n_compared == 0 ||
        response.beyond_db <= response.tolerance_db) {
      continue;
    }
    std::string text = formatted(
        "The %s loop, %s, is not what the model says: a measured singular value lies %.3g dB "
        "beyond its band, allowed are %.3g dB.",
        response.loop.c_str(), response.what.c_str(), response.beyond_db, response.tolerance_db);
    if (response.unmeasured_largest_db > response.tolerance_db) {
      text += " The floor's nodes can also move in " + std::to_string(response.n_unmeasured) +
              (response.n_unmeasured == 1 ? " direction" : " directions") +
              " that no input measures: " +
              formatted(
                  "as much motion there as along the inputs "
                  "would shift a value by up to %.3g dB.",
                  response.unmeasured_largest_db);
    }
    if (const std::string doubt = forces_in_doubt(verdict); !doubt.empty()) {
      text += " But " + doubt + ".";
    }
    verdict.warnings.push_back(std::move(text));
  }
}

void warn_of_plants(const report::LogScan& scan, const std::string& log, report::Verdict& verdict) {
  const std::string text = plants_in_words(scan);
  if (text.empty()) return;
  verdict.warnings.push_back(
      log + ": " + text +
      "; what the controller counted over all of them by its end is left out and not judged.");
}

/// Hz, the targets of a loop that is known.
std::vector<double> targets_of(const LoopDesign& design) {
  if (!design.gains.target_hz.empty()) return design.gains.target_hz;
  const auto target = target_of(design);
  return target ? std::vector{target->frequency_hz} : std::vector<double>{};
}

/// Both loops on a multisine against the sampled prediction, reduced from twice the lowest target.
std::optional<report::IdentificationSummary> judged(const RunAnalyses& runs,
                                                    const std::vector<double>& targets) {
  if (!runs.passive || !runs.active || !runs.any().run.multisine || !runs.same_floor() ||
      targets.empty() || !runs.passive->matrix || !runs.active->matrix) {
    return std::nullopt;
  }
  const double above_hz = 2 * *std::min_element(targets.begin(), targets.end());
  const auto &open = runs.passive->matrix->errors, &closed = runs.active->matrix->errors;
  const auto reduction = reduction_check(runs, above_hz);
  if (!open || !closed || !reduction) return std::nullopt;
  auto summary =
      report::summarise(open->sampled, closed->sampled, *reduction,
                        runs.active->matrix->measured.response->frequencies_hz, above_hz);
  summary.forces_unknown =
      !runs.passive->data.forces_unknown.empty() || !runs.active->data.forces_unknown.empty();
  return summary;
}

}  // namespace

void add_levels(const SceneAcceptance& accept, const std::string& axis,
                const report::SignalAnalysis* floor, const report::SignalAnalysis* passive,
                const report::SignalAnalysis* active, const report::ForcesPart* forces,
                report::Verdict& verdict) {
  report::AxisLevels levels;
  levels.axis = axis;
  if (floor != nullptr) {
    levels.floor = report::motion_level(*floor);
    levels.floor_spectra = report::motion_spectra(*floor);
  }
  if (passive != nullptr) {
    levels.passive = report::motion_level(*passive);
    levels.passive_spectra = report::motion_spectra(*passive);
  }
  if (active != nullptr) {
    levels.active = report::motion_level(*active);
    levels.active_spectra = report::motion_spectra(*active);
  }
  levels.asked = report::asked_of(accept, levels.axis, verdict);
  if (floor == nullptr) {
    std::erase_if(levels.asked, [](const auto& motion) {
      return !motion.by_scene && motion.asked.rms_of_floor.has_value();
    });
  }
  for (report::AskedMotion& motion : levels.asked) {
    report::fill_levels(motion, floor, passive, active, forces);
  }
  verdict.axes.push_back(std::move(levels));
}

report::Verdict verdict_of(const RunAnalyses& runs) {
  report::Verdict verdict;
  for (const auto* run : {&runs.passive, &runs.active}) {
    if (*run) add_run(verdict, **run);
  }
  if (const auto& plan = runs.any().run.multisine) verdict.floors_apart = plan->n_blocks > 1;
  SceneAcceptance accept;
  FrequencyRange range = verdict.judged;
  std::vector<double> targets;
  if (const auto& design = runs.any().run.design) {
    accept = acceptance_of(design->scene);
    targets = targets_of(*design);
    verdict.disturbed = has_forces(design->scene);
    verdict.judged = range = report::judged_range(axis_of(*design));
  }
  if (!targets.empty()) {
    verdict.isolates_above_hz = 2 * *std::max_element(targets.begin(), targets.end());
  }
  if (!runs.same_floor()) {
    verdict.warnings.push_back(
        "The passive and the active run stood on floors of their own (" +
        runs.passive->log.filename().string() + ", " + runs.active->log.filename().string() +
        "): each is set against its own floor, and neither against the other.");
  }
  if (runs.active && !runs.active->run.hold_unknown.empty()) {
    verdict.warnings.push_back(
        "All of the active log is judged, with the passive frame in it before its loop took "
        "hold: " +
        runs.active->run.hold_unknown + ".");
  }
  for (const auto* run : {&runs.passive, &runs.active}) {
    if (!*run) continue;
    warn_of_plants((*run)->data.scan, (*run)->log.filename().string(), verdict);
    // Those of either stand behind what is set against the other.
    if (verdict.forces_unknown.empty()) verdict.forces_unknown = (*run)->data.forces_unknown;
  }
  verdict.identification = judged(runs, targets);
  add_axes(verdict, runs, accept);
  if (const auto& plan = runs.any().run.multisine) {
    verdict.judged = with_lines(range, *plan);
    if (!runs.active || !runs.active->run.never_held()) {
      add_multisine_levels(accept, runs, verdict);
    }
  }
  add_warnings(verdict);
  std::vector<report::Check> checks;
  if (!runs.active || !runs.active->run.never_held()) {
    checks = prediction_checks(runs, verdict, accept.prediction_db);
    if (auto motion = multisine_motion(accept, runs, range)) checks.push_back(std::move(*motion));
  }
  verdict.judgement = report::judge(verdict, accept, std::move(checks));
  return verdict;
}

}  // namespace stillframe::judge
