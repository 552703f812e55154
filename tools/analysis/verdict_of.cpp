#include "tools/analysis/verdict_of.hpp"

#include "report/analysis/summaries.hpp"
#include "report/table.hpp"
#include "tools/analysis/loop_comparison.hpp"
#include "tools/analysis/loop_target.hpp"

namespace stillframe::tools {

namespace {

report::ResponseSummary summary_of(const JudgedResponse& response, const std::string& loop) {
  const report::IdentifiedResponse& measured = response.measured;
  report::ResponseSummary summary;
  summary.loop = loop;
  summary.what = report::cell("%zu %s to %zu %s", measured.signals.inputs.size(),
                              measured.signals.inputs.size() == 1 ? "input" : "inputs",
                              measured.signals.outputs.size(),
                              measured.signals.outputs.size() == 1 ? "output" : "outputs");
  summary.method = measured.method;
  summary.missing = measured.missing.empty() ? response.unpredicted : measured.missing;
  summary.n_segments = measured.n_segments;
  summary.n_filled = measured.n_filled;
  summary.n_left_out = measured.n_left_out;
  summary.resolution_hz = measured.resolution_hz;
  if (measured.response) {
    summary.n_frequencies = static_cast<int>(measured.response->n_frequencies());
  }
  if (const auto errors = prediction_errors(response)) {
    summary.n_compared = static_cast<int>(errors->sampled.n_compared);
    summary.sampled_largest_db = errors->sampled.largest_db;
    summary.sampled_at_hz = errors->sampled.at_frequency_hz;
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
  append(verdict.timing, report::timing_summaries(log));
  append(verdict.shocks, report::shock_summaries(log));
  std::optional<double> limit;
  if (run.run.design) limit = run.run.design->gains.force_limit_n;
  append(verdict.effort, report::effort_summaries(log, limit));
  for (const auto* response : {&run.matrix, &run.axes}) {
    if (*response) verdict.responses.push_back(summary_of(**response, loop));
  }
  append(verdict.noise, report::noise_summaries(log));
  if (run.axes && run.axes->measured.response) {
    append(verdict.transmissibility, report::transmissibilities(log, *run.axes->measured.response));
  }
}

void add_axes(report::Verdict& verdict, const RunAnalyses& runs) {
  const auto axis_of = [](const std::optional<RunAnalysis>& run, std::size_t a) {
    return run && a < run->data.axes.size() ? &run->data.axes[a] : nullptr;
  };
  for (std::size_t a = 0; a < runs.any().data.axes.size(); ++a) {
    report::AxisLevels levels;
    const auto *passive = axis_of(runs.passive, a), *active = axis_of(runs.active, a);
    const report::AxisAnalysis& any = active != nullptr ? *active : *passive;
    levels.axis = any.name;
    levels.floor = report::motion_level(any.floor);
    levels.floor_spectra = report::motion_spectra(any.floor);
    if (passive != nullptr) {
      levels.passive = report::motion_level(passive->frame);
      levels.passive_spectra = report::motion_spectra(passive->frame);
    }
    if (active != nullptr) {
      levels.active = report::motion_level(active->frame);
      levels.active_spectra = report::motion_spectra(active->frame);
    }
    verdict.axes.push_back(std::move(levels));
  }
}

/// Both loops on a multisine against the sampled prediction.
std::optional<report::IdentificationSummary> judged(const RunAnalyses& runs,
                                                    std::optional<double> target_hz) {
  if (!runs.passive || !runs.active || !runs.any().run.multisine) return std::nullopt;
  if (!target_hz && runs.active->run.design) {
    if (const auto target = target_of(*runs.active->run.design)) target_hz = target->frequency_hz;
  }
  if (!target_hz || !runs.passive->matrix || !runs.active->matrix) return std::nullopt;
  const auto open = prediction_errors(*runs.passive->matrix);
  const auto closed = prediction_errors(*runs.active->matrix);
  const auto reduction = reduction_check(runs, 2 * *target_hz);
  if (!open || !closed || !reduction) return std::nullopt;
  return report::summarise(open->sampled, closed->sampled, *reduction,
                           runs.active->matrix->measured.response->frequencies_hz, 2 * *target_hz,
                           report::default_least_coherence, allowed_db);
}

}  // namespace

report::Verdict verdict_of(const RunAnalyses& runs, std::optional<double> target_hz) {
  report::Verdict verdict;
  for (const auto* run : {&runs.passive, &runs.active}) {
    if (*run) add_run(verdict, **run);
  }
  verdict.identification = judged(runs, target_hz);
  add_axes(verdict, runs);
  return verdict;
}

}  // namespace stillframe::tools
