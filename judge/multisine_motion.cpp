#include "judge/multisine_motion.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/errors/formatted.hpp"
#include "core/numerics/infinity.hpp"
#include "judge/verdict_of.hpp"
#include "report/verdict/motion_level.hpp"

namespace stillframe::judge {

using report::Check;
using report::Outcome;
using report::Subject;

namespace {

/// Of the lines of two responses in a range: what an output makes of the inputs, with control over
/// without, and by how much noise may have changed that.
struct MultisineGain {
  double passive = 0, active = 0;  ///< of the lines together
  double found = 0, least = 0, most = 0;
};

MultisineGain gain_of(const report::FrequencyResponse& open,
                      const report::FrequencyResponse& closed, Eigen::Index output, double from_hz,
                      double to_hz) {
  double power[2] = {0, 0}, noise[2] = {0, 0};
  for (Eigen::Index l = 0; l < open.n_frequencies(); ++l) {
    const auto at = static_cast<std::size_t>(l);
    const double f = open.frequencies_hz[at];
    if (f < from_hz || f > to_hz) continue;
    for (const int i : {0, 1}) {
      const report::FrequencyResponse& response = i == 0 ? open : closed;
      power[i] += response.T[at].row(output).squaredNorm();
      noise[i] += std::real(response.noise[at](output, output)) *
                  std::real(response.input_weight[at].trace());
    }
  }
  const double passive = std::sqrt(power[0]), active = std::sqrt(power[1]);
  // Twice the standard deviation, as a 95 % band has.
  const double of_passive = 2 * std::sqrt(noise[0]), of_active = 2 * std::sqrt(noise[1]);
  MultisineGain gain{.passive = passive, .active = active};
  gain.found = active / passive;
  gain.least = (active - of_active) / (passive + of_passive);
  gain.most = passive > of_passive ? (active + of_active) / (passive - of_passive) : infinity;
  return gain;
}

const report::FrameAnalysis* frame_of(const std::optional<RunAnalysis>& run,
                                      const std::string& name) {
  if (!run) return nullptr;
  for (const report::FrameAnalysis& frame : run->data.frames) {
    if (frame.name == name) return &frame;
  }
  return nullptr;
}

/// Why its signals say nothing: one rests where it should not.
std::string resting_in(const report::Verdict& verdict, const ComparedFrame& compared) {
  for (const report::RunSummary& run : verdict.runs) {
    for (const report::RestingChannel& channel : run.resting_channels) {
      if (channel.name != compared.floor && channel.name != compared.frame) continue;
      return channel.text() + " never changes in the log of the " + run.loop +
             " run though what moves the frame does";
    }
  }
  return {};
}

bool is_asked_by_name(const SceneAcceptance& accept, const Scene& scene, const std::string& frame) {
  for (const SceneComparison& comparison : scene.comparisons) {
    if (comparison.frame != frame) continue;
    const bool asked = std::any_of(accept.axes.begin(), accept.axes.end(),
                                   [&](const auto& a) { return a.axis == comparison.name; });
    if (asked) return true;
  }
  return false;
}

}  // namespace

std::vector<ComparedFrame> compared_frames(const Scene& scene, const MultisinePlan* multisine) {
  const bool apart = multisine != nullptr && multisine->n_blocks > 1;
  std::vector<ComparedFrame> frames;
  for (const SceneComparison& comparison : scene.comparisons) {
    frames.push_back({comparison.name, apart ? std::string() : comparison.floor, comparison.frame});
  }
  if (multisine == nullptr) return frames;
  for (const SceneSignal& output : scene.outputs) {
    const bool named = std::any_of(frames.begin(), frames.end(),
                                   [&](const auto& f) { return f.frame == output.name; });
    if (!named) frames.push_back({output.name, {}, output.name});
  }
  return frames;
}

void add_multisine_levels(const SceneAcceptance& accept, const RunAnalyses& runs,
                          report::Verdict& verdict) {
  const auto& run = runs.any().run;
  if (!runs.active || !run.multisine || !run.design || !runs.same_floor()) return;
  for (const ComparedFrame& compared : compared_frames(run.design->scene, &*run.multisine)) {
    const auto *passive = frame_of(runs.passive, compared.frame),
               *active = frame_of(runs.active, compared.frame),
               *floor = frame_of(runs.active, compared.floor);
    if (active == nullptr || (passive == nullptr && floor == nullptr)) continue;
    const auto motion = [](const report::FrameAnalysis* frame) {
      return frame != nullptr ? &frame->motion : nullptr;
    };
    add_levels(accept, compared.name, motion(floor), motion(passive), motion(active),
               active->forces ? &*active->forces : nullptr, verdict);
    verdict.axes.back().resting = resting_in(verdict, compared);
  }
}

std::optional<Check> multisine_motion(const SceneAcceptance& accept, const RunAnalyses& runs,
                                      const FrequencyRange& judged) {
  if (!runs.passive || !runs.active || !runs.any().run.multisine || !runs.same_floor() ||
      !runs.passive->matrix || !runs.active->matrix) {
    return std::nullopt;
  }
  const auto &open = runs.passive->matrix->measured, &closed = runs.active->matrix->measured;
  if (!open.response || !closed.response ||
      open.response->frequencies_hz != closed.response->frequencies_hz) {
    return std::nullopt;
  }
  const std::vector<double>& lines = open.response->frequencies_hz;
  const bool levels = std::any_of(lines.begin(), lines.end(), [&](double f) {
    return f >= judged.lowest_hz && f <= judged.highest_hz;
  });
  const double from_hz = levels ? judged.lowest_hz : 0,
               to_hz = levels ? judged.highest_hz : infinity;
  const auto& design = runs.any().run.design;
  std::vector<MultisineGain> gains;
  double largest = 0;
  for (std::size_t i = 0; i < open.signals.outputs.size(); ++i) {
    gains.push_back(
        gain_of(*open.response, *closed.response, static_cast<Eigen::Index>(i), from_hz, to_hz));
    largest = std::max(largest, gains.back().passive);
  }
  // As of the levels (moves_too_little): lines of the one may be products of what others move.
  const double too_little = report::least_axis_share * largest;
  std::optional<MultisineGain> worst;
  std::string of;
  for (std::size_t i = 0; i < open.signals.outputs.size(); ++i) {
    if (design && is_asked_by_name(accept, design->scene, open.signals.outputs[i])) continue;
    const MultisineGain& gain = gains[i];
    if (gain.passive <= too_little && gain.active <= too_little) continue;
    // One that is no number, or known to be worse, is not hidden by one of which that is not known.
    const auto rank = [](const MultisineGain& g) {
      return std::tuple(std::isnan(g.found), g.least > 1, g.found);
    };
    if (worst && rank(gain) <= rank(*worst)) continue;
    worst = gain;
    of = open.signals.outputs[i];
  }
  if (!worst) return std::nullopt;
  const std::string range = levels ? formatted("%g to %g Hz", from_hz, to_hz)
                                   : "all " + std::to_string(lines.size()) + " lines";
  Check check{
      .subject = Subject::motion,
      .what = "output " + of + ", active to passive frame, lines of the multisine, " + range,
      .asked = "at most 1",
      .found = formatted("%.4g", worst->found),
      .outcome = report::at_most(worst->found, 1),
      .reason = "Output " + of + ": the active frame makes " + formatted("%.4g", worst->found) +
                " times as much of the multisine as the passive one (" + range + "), allowed is 1.",
      .by_scene = false};
  if (worst->found <= 1 ? worst->most > 1 : worst->least <= 1) {
    check.outcome = Outcome::not_judged;
    check.reason = "Output " + of + ": the active frame makes " + formatted("%.4g", worst->found) +
                   " times as much of the multisine as the passive one (" + range +
                   "), which noise leaves known from " +
                   formatted("%.3g", std::max(worst->least, 0.0)) + " to " +
                   formatted("%.3g", worst->most) + " only.";
  }
  return check;
}

}  // namespace stillframe::judge
