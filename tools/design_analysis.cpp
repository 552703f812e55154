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
  FrequencyLine line{.hz = hz,
                     .open = singular_values(design.loop.open(s)),
                     .closed = singular_values(design.loop.closed(s))};
  const Eigen::MatrixXcd T = transfer(design.closed, two_pi * hz);
  line.sampled = singular_values(T);
  line.noise = singular_values(noise_transfer(design.closed, two_pi * hz))(0);
  line.compliance = singular_values(compliance.closed(s, design.settings.feedback))(0);
  line.passive_compliance = singular_values(compliance.open(s))(0);
  if (T.rows() == T.cols()) line.decoupling = decoupling(T);
  return line;
}

/// The poles of the design model without leak, each against the nearest target of its modulus.
OrderEffect effect_of(const LoopDesign& design, GainOrder order) {
  const DesignModel& model = design.loop.design;
  const auto targets = mode_targets(*design.scene.controller, model.legs.M.rows());
  const Eigen::VectorXcd poles = closed_loop_poles(
      model.legs, extended_gains(model.legs, targets, order), targets.front().omega_d);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  OrderEffect effect;
  effect.poles = {.lowest = infinity, .highest = 0, .largest_real = -infinity};
  for (const Complex pole : poles) {
    if (pole == Complex(0)) continue;  // of the pure integrators
    double nearest = infinity;
    for (const ModeTarget& target : targets) {
      const double ratio = std::abs(pole) / target.omega_d;
      if (std::abs(std::log(ratio)) < std::abs(std::log(nearest))) nearest = ratio;
    }
    effect.poles.lowest = std::min(effect.poles.lowest, nearest);
    effect.poles.highest = std::max(effect.poles.highest, nearest);
    effect.poles.largest_real = std::max(effect.poles.largest_real, pole.real());
  }
  const Eigen::MatrixXd MK = model.legs.M * model.legs.K;
  effect.same = (MK - MK.transpose()).norm() <= 1e-9 * MK.norm();
  return effect;
}

/// Largest excess of the sampled over the continuous T up to four targets, dB.
double price_of_sampling(const LoopDesign& design, const SampledLoop& sampled) {
  const double target = design.scene.controller->lowest_target_hz();
  const double to = std::min(4 * target, 0.49 / sampled.sample_time);
  double price = -std::numeric_limits<double>::infinity();
  for (const double hz : logarithmic_frequencies(target / 4, to, 25)) {
    const double ideal = singular_values(design.loop.closed({0, two_pi * hz}))(0);
    const double real = singular_values(transfer(sampled, two_pi * hz))(0);
    price = std::max(price, 20 * std::log10(real / ideal));
  }
  return price;
}

}  // namespace

std::optional<RecommendedRate> recommended_rate(const LoopDesign& design, double price_db,
                                                double disk) {
  const double target = design.scene.controller->lowest_target_hz();
  for (double decade = 1; decade < 1e5; decade *= 10) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double rate = decade * factor;
      if (rate < 4 * target) continue;
      const LoopSettings settings = at_rate(design.settings, rate);
      if (!(spectral_radius(settings) < largest_stable_radius)) continue;
      const double price = price_of_sampling(design, close_loop(settings));
      if (price > price_db) continue;
      const double alpha = all_leg_disk_margin(settings).first;
      if (alpha < disk) continue;
      return RecommendedRate{rate, price, alpha};
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
  out.recommended = recommended_rate(design);
  out.warnings = design_warnings(design, out);
  return out;
}

}  // namespace stillframe::tools
