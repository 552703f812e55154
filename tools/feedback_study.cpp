#include "tools/feedback_study.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "controller/law_block.hpp"
#include "core/control/disk_margin.hpp"
#include "core/control/margins.hpp"
#include "core/control/minimax_law.hpp"
#include "core/control/mode_design.hpp"
#include "core/control/own_law.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/singular_values.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/systems/resonances.hpp"
#include "core/yaml/reader.hpp"
#include "judge/scene_design.hpp"

namespace stillframe::tools {

using Eigen::VectorXd;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// 1, 2 and 5 times powers of ten, from a fifth of the target to nearly half the rate.
VectorXd round_frequencies_hz(double target_hz, double rate_hz) {
  std::vector<double> found;
  for (double decade = 1e-3; decade < rate_hz; decade *= 10) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double hz = digit * decade;
      if (hz >= 0.199 * target_hz && hz <= 0.45 * rate_hz) found.push_back(hz);
    }
  }
  return Eigen::Map<VectorXd>(found.data(), std::ssize(found));
}

VectorXd largest_of(const SampledLoop& loop, const VectorXd& hz) {
  return hz.unaryExpr([&](double f) { return singular_values(transfer(loop, two_pi * f))(0); });
}

/// What is judged of every feedback alike, on the plant of the scene.
void judge_loop(const LoopSettings& settings, const SampledLoop& closed, double lowest_hz,
                const VectorXd& frequencies_hz, FeedbackRow& row) {
  row.n_states = law_of(settings).A.rows();
  row.radius = spectral_radius(closed);
  if (!(row.radius < largest_stable_radius)) {
    row.why_none = "the loop is not stable on the whole plant";
    return;
  }
  row.largest = largest_of(closed, frequencies_hz);
  const double to_hz = 0.4999 / settings.sampling.sample_time;
  const VectorXd grid =
      with_resonances(VectorXd::LinSpaced(400, std::log(lowest_hz), std::log(to_hz)).array().exp(),
                      resonances(eigenvalues(closed.A).value_or(Eigen::VectorXcd()),
                                 settings.sampling.sample_time));
  const VectorXd all = largest_of(closed, grid);
  Index at = 0;
  row.peak = all.maxCoeff(&at);
  row.peak_hz = grid(at);
  for (const double hz : grid) {
    row.noise = std::max(row.noise, singular_values(noise_transfer(closed, two_pi * hz))(0));
  }
  row.disk = all_leg_disk_margin(settings).first;
  LoopSettings off = settings;
  for (const double gain : {0.75, 1.25}) {
    off.sampling.instruments.actuator_gain = gain * settings.sampling.instruments.actuator_gain;
    row.radius_off = std::max(row.radius_off, spectral_radius(off));
  }
  off = settings;
  off.sampling.delay_samples += 1;
  row.radius_off = std::max(row.radius_off, spectral_radius(off));
}

/// The lead with which a PI keeps a margin and isolates best at a frequency, if there is one.
std::optional<double> lead_for(LoopSettings settings, double disk, double at_hz) {
  std::optional<double> best;
  double lowest = infinity;
  constexpr int steps = 100;
  const double most = std::max(2.0, 1.25 * settings.law.lead_samples);
  for (int i = 0; i <= steps; ++i) {
    settings.law.lead_samples = most * i / steps;
    const SampledLoop closed = close_loop(settings);
    if (!(spectral_radius(closed) < largest_stable_radius)) continue;
    const double value = singular_values(transfer(closed, two_pi * at_hz))(0);
    if (!(value < lowest) || !(all_leg_disk_margin(settings, disk).first >= disk)) continue;
    lowest = value;
    best = settings.law.lead_samples;
  }
  return best;
}

FeedbackRow pi_row(const judge::LoopDesign& design, double lead, double lowest_hz,
                   const VectorXd& frequencies_hz) {
  FeedbackRow row{.method = "pi", .lead_samples = lead, .why_none = {}, .largest = {}, .law = {}};
  LoopSettings settings = design.settings;
  settings.law.lead_samples = lead;
  settings.feed_forward = {};
  judge_loop(settings, close_loop(settings), lowest_hz, frequencies_hz, row);
  return row;
}

std::string law_text(const FeedbackRow& row, const judge::LoopDesign& design, const NamedLaw& law) {
  std::string title = design.scene.title;
  std::replace(title.begin(), title.end(), '\n', ' ');
  return "# By stillframe feedback, method " + row.method + ", for: " + title +
         "\nsample_rate_hz: " + shortest_digits(design.gains.sample_rate_hz) + "\n" +
         controller::law_block(law, "");
}

FeedbackRow designed_row(const judge::LoopDesign& design, const FrameFeedback& feedback,
                         double applied_memory, double lowest_hz, const VectorXd& frequencies_hz,
                         std::string method) {
  FeedbackRow row{
      .method = std::move(method), .lead_samples = {}, .why_none = {}, .largest = {}, .law = {}};
  if (!feedback.law) {
    for (Index i = 0; i < feedback.hz.size(); ++i) {
      if (feedback.modes[static_cast<std::size_t>(i)]) continue;
      row.why_none = "finds none that keeps the margin for the mode of " +
                     shortest_digits(std::round(100 * feedback.hz(i)) / 100) + " Hz";
      return row;
    }
  }
  const LinearSystem& F = *feedback.law;
  const NamedLaw law = named({.A = F.A,
                              .B = F.B,
                              .C = F.C,
                              .D = F.D,
                              .subtract_applied = true,
                              .applied_memory = applied_memory},
                             design.gains.legs, {});
  row.law = law_text(row, design, law);
  Scene scene = design.scene;
  SceneController& block = *scene.controller;
  block.law = SceneLaw{.file = row.method + ".yaml", .bytes = row.law};
  block.realisation = Realisation::implicit_feedthrough;
  block.leak_hz = block.high_pass_hz = block.lead_samples = 0;
  block.roll_off_hz.reset();
  block.feed_forward.reset();
  // As it will be read from its file.
  const judge::LoopDesign own = judge::make_loop_design(std::move(scene));
  judge_loop(own.settings, own.closed, lowest_hz, frequencies_hz, row);
  row.n_states = F.A.rows();
  if (!row.why_none.empty()) row.law.clear();
  return row;
}

/// The PI of a mode by its lead, and both designs by the margin that they are asked for.
std::vector<MarginPoint> margin_curve(const judge::LoopDesign& design, const SampledMode& mode,
                                      ModeGoal goal,
                                      const std::function<void(const std::string&)>& now) {
  std::vector<MarginPoint> curve;
  const ModeResponses at(mode, goal);
  const double X = std::pow(mode.omega() / goal.omega_d, 2);
  ForceFeedback pi = design.settings.feedback;
  pi.K_P = Eigen::MatrixXd::Constant(1, 1, X - 1);
  pi.K_I = Eigen::MatrixXd::Constant(1, 1, 2 * goal.zeta * goal.omega_d * X);
  LawSampling sampling = design.settings.law;
  sampling.sample_time = mode.sampling().sample_time;
  sampling.sensor_filter_hz = mode.sampling().instruments.sensor_filter_hz;
  for (int i = 0; i <= 20; ++i) {
    sampling.lead_samples = 0.1 * i;
    const DiscreteLaw law = sample_law(pi, sampling);
    const LinearSystem F{law.A, law.B, law.C, law.D};
    if (!(mode.radius(F) < largest_stable_radius)) continue;
    curve.push_back({"pi", mode.disk_margin(F), level_of(goal, at.hz, at.T(at.of(F))), nan});
  }
  // From wide margins to thin ones: a law that keeps more than is asked for is one as well.
  double of_h2 = infinity, of_minimax = of_h2;
  const auto add = [&](const char* method, const ModeLaw& law, double bound_db, double& lowest) {
    if (!(law.level_db < lowest)) return;
    lowest = law.level_db;
    curve.push_back({method, law.disk, law.level_db, bound_db});
  };
  for (const double disk : {1.0, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2}) {
    now("curve, margin " + shortest_digits(disk));
    goal.disk = disk;
    if (const auto law = h2_mode_law(mode, goal)) add("h2", *law, nan, of_h2);
    const MinimaxLaw found = minimax_mode_law(mode, goal);
    if (found.law) add("minimax", *found.law, found.bound_db, of_minimax);
  }
  return curve;
}

}  // namespace

FeedbackStudy feedback_study(const judge::LoopDesign& design, const FeedbackWish& wish,
                             const std::function<void(const std::string&)>& now) {
  const SceneController& block = *design.scene.controller;
  const double rate_hz = design.gains.sample_rate_hz, target_hz = block.lowest_target_hz();
  FeedbackStudy study{.disk = wish.disk,
                      .to_hz = wish.to_hz > 0 ? wish.to_hz : std::min(rate_hz / 20, 20 * target_hz),
                      .frequencies_hz = round_frequencies_hz(target_hz, rate_hz),
                      .target = {},
                      .passive = {},
                      .rows = {},
                      .curve = {}};
  const auto targets = mode_targets(block, design.loop.design.legs.M.rows());
  ModeGoal goal{.omega_d = targets.front().omega_d,
                .zeta = targets.front().zeta,
                .to_hz = study.to_hz,
                .disk = wish.disk};
  study.target =
      target_size({.omega_d = two_pi * target_hz, .zeta = goal.zeta}, study.frequencies_hz);
  study.passive = largest_of(design.open, study.frequencies_hz);
  const double lowest_hz = 0.05 * target_hz;
  const auto add_pi = [&](double lead) {
    study.rows.push_back(pi_row(design, lead, lowest_hz, study.frequencies_hz));
  };
  now("pi");
  add_pi(design.settings.law.lead_samples);
  if (!(study.rows.front().disk >= wish.disk)) {
    const auto lead = lead_for(design.settings, wish.disk, std::min(4 * target_hz, study.to_hz));
    if (lead) add_pi(*lead);
  }
  const double memory = law_of(design.settings).applied_memory;
  FrameFeedback feedback;
  for (const auto& [method, name] :
       {std::pair{FeedbackMethod::h2, "h2"}, std::pair{FeedbackMethod::minimax, "minimax"}}) {
    now(name);
    feedback =
        frame_feedback(design.loop.design, targets, design.settings.sampling, memory, goal, method);
    study.rows.push_back(
        designed_row(design, feedback, memory, lowest_hz, study.frequencies_hz, name));
  }
  study.stiffest_hz = feedback.hz(feedback.hz.size() - 1);
  if (wish.curve) {
    goal.omega_d = targets.back().omega_d;
    goal.zeta = targets.back().zeta;
    const SampledMode mode(two_pi * study.stiffest_hz, design.settings.sampling, memory);
    study.curve = margin_curve(design, mode, goal, now);
  }
  return study;
}

}  // namespace stillframe::tools
