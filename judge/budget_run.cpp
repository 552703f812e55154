#include "judge/budget_run.hpp"

#include <cmath>

#include "core/errors/input_error.hpp"
#include "report/analysis/log_analyser.hpp"
#include "report/spectra/vibration_criteria.hpp"

namespace stillframe::judge {

using Eigen::Index;
using Eigen::MatrixXd;
using stillframe_msgs::run_info_t;

namespace {

bool alike(const MatrixXd& a, const MatrixXd& b) {
  // Another machine rounds otherwise.
  constexpr double rounding = 1e-9;
  return a.rows() == b.rows() && a.cols() == b.cols() && (a - b).norm() <= rounding * b.norm();
}

/// With which of a design's laws a log was run; nothing if with none of them.
std::optional<BudgetMethod> method_of(const controller::Gains& of_log,
                                      const controller::Gains& of_design) {
  const bool same =
      alike(of_log.K_P, of_design.K_P) && alike(of_log.K_I, of_design.K_I) &&
      of_log.sample_rate_hz == of_design.sample_rate_hz &&
      of_log.delay_samples == of_design.delay_samples &&
      of_log.lead_samples == of_design.lead_samples && of_log.leak_hz == of_design.leak_hz &&
      of_log.high_pass_hz == of_design.high_pass_hz &&
      of_log.roll_off_hz == of_design.roll_off_hz && of_log.realisation == of_design.realisation;
  if (!same) return std::nullopt;
  if (of_log.heard_floor().empty()) return BudgetMethod::feedback;
  // A law of one's own is part of the hash of the scene.
  if (!alike(of_log.feed_forward.filter.weights, of_design.feed_forward.filter.weights)) {
    return std::nullopt;
  }
  return BudgetMethod::feed_forward;
}

BudgetMethod method_of(const run_info_t& info, const std::string& place, const LoopDesign& design,
                       const std::string& floor_text) {
  if (info.scene_hash != design.scene.hash) {
    throw InputError(place + ": scene_hash: found " + info.scene_hash + ", allowed is that of " +
                     design.scene.file + " and its controller block, " + design.scene.hash);
  }
  if (info.floor_text != floor_text) {
    throw InputError(place +
                     ": floor_text: the run was on another floor than the budget; allowed is the "
                     "same block, as the scene has it or as --floor gives it");
  }
  if (info.loop != "active") return BudgetMethod::passive;
  if (info.mode == "wall_clock") {
    throw InputError(place +
                     ": mode: found wall_clock, allowed are lock_step and single_process: by the "
                     "clock a loop takes hold of its frame while the run goes on");
  }
  const auto method =
      method_of(controller::parse_gains(info.gains_text, place + ": gains_text"), design.gains);
  if (!method) {
    throw InputError(place + ": gains_text: found other gains than those of " + design.scene.file +
                     ", allowed are these, with or without their feed-forward");
  }
  return *method;
}

}  // namespace

BudgetRun budget_run(const std::filesystem::path& log, const LoopDesign& design,
                     const std::string& floor_text, const std::vector<ComparedFrame>& axes) {
  BudgetRun run{.log = log, .method = {}, .n_samples = 0, .axes = {}};
  const report::LogAnalysis data = report::analyse_log(log, {}, [&](const run_info_t& info) {
    run.method = method_of(info, log.string(), design, floor_text);
    report::AnalysisPlan plan;
    for (const ComparedFrame& axis : axes) plan.frames.push_back(axis.frame);
    return plan;
  });
  run.n_samples = data.scan.info.n_samples;
  if (data.n_judged != run.n_samples) {
    throw InputError(log.string() + ": holds " + std::to_string(data.n_judged) + " of " +
                     std::to_string(run.n_samples) +
                     " samples; allowed is a whole run, whose budget can be made");
  }
  for (const report::FrameAnalysis& frame : data.frames) {
    run.axes.push_back({.rms = frame.motion.rms,
                        .velocity = frame.motion.third_octaves,
                        .vibration_class = report::vibration_class(frame.motion.third_octaves)});
  }
  return run;
}

bool BudgetCheck::met(double within) const {
  return std::abs(measured - predicted) <= within * measured + 2 * scatter;
}

std::vector<BudgetCheck> checks_of(const Budget& budget, const std::vector<BudgetRun>& runs) {
  std::vector<BudgetCheck> checks;
  for (const BudgetRun& run : runs) {
    const MethodBudget* of_method = budget.of(run.method);
    if (of_method == nullptr) continue;
    for (std::size_t i = 0; i < budget.axes.size(); ++i) {
      const SignalBudget& axis = of_method->axes[i];
      checks.push_back({.axis = budget.axes[i].name,
                        .method = run.method,
                        .predicted = axis.total.rms,
                        .scatter = axis.scatter,
                        .measured = run.axes[i].rms});
    }
  }
  return checks;
}

}  // namespace stillframe::judge
