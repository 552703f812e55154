#include "tools/design_analysis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/compliance.hpp"
#include "core/frequency_response.hpp"
#include "core/gain_design.hpp"
#include "tools/design_warnings.hpp"

namespace stillframe::tools {

namespace {

constexpr double two_pi = 2 * std::numbers::pi;
using Complex = std::complex<double>;

FrequencyLine line_at(const LoopDesign& design, const Compliance& compliance, double hz) {
  const Complex s(0, two_pi * hz);
  FrequencyLine line;
  line.hz = hz;
  line.open = singular_values(design.loop.open(s));
  line.closed = singular_values(design.loop.closed(s));
  const Eigen::MatrixXcd T = transfer(design.closed, two_pi * hz);
  line.sampled = singular_values(T);
  line.noise = singular_values(noise_transfer(design.closed, two_pi * hz))(0);
  line.compliance = singular_values(compliance.closed(s, design.settings.feedback))(0);
  line.passive_compliance = singular_values(compliance.open(s))(0);
  if (T.rows() == T.cols()) line.decoupling = decoupling(T);
  return line;
}

/// The poles of the design model without leak, each against the nearest target of its modulus.
PoleSpread effect_of(const LoopDesign& design, GainOrder order) {
  const DesignModel& model = design.loop.design;
  const auto targets = mode_targets(*design.scene.controller, model.legs.M.rows());
  const Eigen::VectorXcd poles = closed_loop_poles(
      model.legs, extended_gains(model.legs, targets, order), targets.front().omega_d);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  PoleSpread effect{.lowest = infinity, .highest = 0, .largest_real = -infinity};
  for (const Complex pole : poles) {
    if (pole == Complex(0)) continue;  // of the pure integrators
    double nearest = infinity;
    for (const ModeTarget& target : targets) {
      const double ratio = std::abs(pole) / target.omega_d;
      if (std::abs(std::log(ratio)) < std::abs(std::log(nearest))) nearest = ratio;
    }
    effect.lowest = std::min(effect.lowest, nearest);
    effect.highest = std::max(effect.highest, nearest);
    effect.largest_real = std::max(effect.largest_real, pole.real());
  }
  return effect;
}

/// Whether a loop is stable and meets the rule of `recommend`.
std::optional<Recommendation> judged(const LoopDesign& design, const LoopSettings& settings) {
  if (!(spectral_radius(settings) < largest_stable_radius)) return std::nullopt;
  const double price =
      price_of_sampling(design.loop, design.scene.controller->lowest_target_hz(), settings);
  if (price > 3) return std::nullopt;
  if (!has_disk_margin(settings, 0.5)) return std::nullopt;
  Recommendation found{.rate_hz = 1 / settings.sampling.sample_time,
                       .lead_samples = settings.law.lead_samples,
                       .roll_off_hz = {},
                       .price_db = price,
                       .disk = all_leg_disk_margin(settings).first};
  if (settings.feedback.roll_off > 0) found.roll_off_hz = settings.feedback.roll_off / two_pi;
  return found;
}

}  // namespace

double matched_lead(const LoopSettings& settings, double roll_off) {
  const Sampling& sampling = settings.sampling;
  double lead = sampling.delay_samples + 0.5;
  if (roll_off > 0) lead += 1 / (roll_off * sampling.sample_time);
  const double lag = two_pi * sampling.instruments.actuator_lag_hz;
  return lag > 0 ? lead + 1 / (lag * sampling.sample_time) : lead;
}

double price_of_sampling(const ControlLoop& loop, double target, const LoopSettings& settings) {
  ControlLoop ideal = loop;
  ideal.gains.roll_off = 0;
  const SampledLoop sampled = close_loop(settings);
  const double to = std::min(4 * target, 0.49 / sampled.sample_time);
  double price = -std::numeric_limits<double>::infinity();
  for (const double hz : logarithmic_frequencies(target / 4, to, 15)) {
    const double without = singular_values(ideal.closed({0, two_pi * hz}))(0);
    const double real = singular_values(transfer(sampled, two_pi * hz))(0);
    price = std::max(price, 20 * std::log10(real / without));
  }
  return price;
}

std::optional<Recommendation> recommend(const LoopDesign& design) {
  const double target = design.scene.controller->lowest_target_hz();
  constexpr double highest = 1e5, none = 0;
  const auto tuned = [&](double rate, double times) {
    LoopSettings settings = at_rate(design.settings, rate);
    if (times == none) return settings;
    settings.feedback.roll_off = two_pi * times * target;
    settings.law.lead_samples = matched_lead(settings, settings.feedback.roll_off);
    return settings;
  };
  // What does not do at the highest rate does at no other.
  std::vector<double> tunings;
  for (const double times : {none, 80.0, 40.0, 20.0}) {
    if (judged(design, tuned(highest, times))) tunings.push_back(times);
  }
  for (double decade = 1; decade < highest && !tunings.empty(); decade *= 10) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double rate = decade * factor;
      if (rate < 4 * target) continue;
      for (const double times : tunings) {
        if (times * target > 0.4 * rate) continue;
        if (const auto found = judged(design, tuned(rate, times))) return found;
      }
    }
  }
  return std::nullopt;
}

DesignAnalysis analyse(const LoopDesign& design) {
  DesignAnalysis out;
  out.poles = closed_loop_poles(design.settings.plant, design.settings.feedback);
  out.exact = effect_of(design, GainOrder::exact);
  out.deck = effect_of(design, GainOrder::deck);
  const Compliance compliance(design.scene, design.model);
  for (const double hz : page_frequencies_hz) out.lines.push_back(line_at(design, compliance, hz));
  out.radius = design.radius;
  LoopSettings misaligned = design.settings;
  ++misaligned.sampling.instruments.report_age_samples;
  out.misaligned_radius = spectral_radius(misaligned);
  if (out.radius < largest_stable_radius) out.margins = margins(design.settings);
  out.rates = stable_rates(design.settings, 2 * design.scene.controller->lowest_target_hz(), 2e5);
  out.recommended = recommend(design);
  out.warnings = design_warnings(design, out);
  return out;
}

}  // namespace stillframe::tools
