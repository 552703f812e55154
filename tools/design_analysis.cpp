#include "tools/design_analysis.hpp"

#include <algorithm>
#include <cmath>

#include "core/control/design/compliance.hpp"
#include "core/control/design/gain_design.hpp"
#include "core/control/design/price_of_sampling.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/two_pi.hpp"
#include "tools/design_remedies.hpp"
#include "tools/design_warnings.hpp"
#include "tools/stability_note.hpp"

namespace stillframe::tools {

namespace {

constexpr double highest_rate_hz = 2e5;
using Complex = std::complex<double>;

/// Displacements from forces on the frame, as the loop runs and with it open.
struct ForceResponses {
  explicit ForceResponses(const judge::LoopDesign& design)
      : plant(sample_and_hold(compliance_plant(design.scene, design.model),
                              design.settings.sampling)),
        open(open_loop(plant)),
        closed(close_loop(plant, law_of(design.settings))) {}
  SampledPlant plant;
  SampledLoop open, closed;
};

/// Whether output i stands where input i acts: of a frame that slowly follows its floor, it is the
/// one that follows that input most. Other outputs may be as many and mean nothing in pairs.
bool outputs_pair_up(const judge::LoopDesign& design, double lowest_hz) {
  const Eigen::MatrixXd T = design.loop.open({0, two_pi * lowest_hz}).cwiseAbs();
  if (T.rows() != T.cols()) return false;
  for (Index i = 0; i < T.rows(); ++i) {
    Index most = 0;
    if (!(T.col(i).maxCoeff(&most) > 0) || most != i) return false;
  }
  return true;
}

FrequencyLine line_at(const judge::LoopDesign& design, const ForceResponses& forces, bool paired,
                      double hz) {
  const Complex s(0, two_pi * hz);
  FrequencyLine line;
  line.hz = hz;
  line.open = singular_values(transfer(design.open, two_pi * hz));
  line.continuous = singular_values(design.loop.closed(s));
  const Eigen::MatrixXcd T = transfer(design.closed, two_pi * hz);
  line.closed = singular_values(T);
  line.noise = singular_values(noise_transfer(design.closed, two_pi * hz))(0);
  line.compliance = singular_values(transfer(forces.closed, two_pi * hz))(0);
  line.passive_compliance = singular_values(transfer(forces.open, two_pi * hz))(0);
  if (paired) line.decoupling = decoupling(T);
  return line;
}

/// The moduli of the poles that a target asks for: omega_d, or those of two real ones.
std::vector<double> moduli_of(const ModeTarget& target) {
  if (target.zeta <= 1) return {target.omega_d};
  const double root = std::sqrt(target.zeta * target.zeta - 1);
  return {target.omega_d / (target.zeta + root), target.omega_d * (target.zeta + root)};
}

/// The poles of the design model without leak, each against the nearest that a target asks for.
PoleSpread effect_of(const judge::LoopDesign& design, GainOrder order) {
  const DesignModel& model = design.loop.design;
  const auto targets = mode_targets(*design.scene.controller, model.legs.M.rows());
  const Eigen::VectorXcd poles = closed_loop_poles(
      model.legs, extended_gains(model.legs, targets, order), targets.front().omega_d);
  PoleSpread effect{.lowest = infinity, .highest = 0, .largest_real = -infinity};
  for (const Complex pole : poles) {
    if (pole == Complex(0)) continue;  // of the pure integrators
    double nearest = infinity;
    for (const ModeTarget& target : targets) {
      for (const double modulus : moduli_of(target)) {
        const double ratio = std::abs(pole) / modulus;
        if (std::abs(std::log(ratio)) < std::abs(std::log(nearest))) nearest = ratio;
      }
    }
    effect.lowest = std::min(effect.lowest, nearest);
    effect.highest = std::max(effect.highest, nearest);
    effect.largest_real = std::max(effect.largest_real, pole.real());
  }
  return effect;
}

double misaligned_radius(LoopSettings settings) {
  ++settings.sampling.instruments.report_age_samples;
  return spectral_radius(settings);
}

/// Whether a loop is stable and meets the rule of `recommend`.
std::optional<Recommendation> judged(const judge::LoopDesign& design,
                                     const LoopSettings& settings) {
  if (!(spectral_radius(settings) < largest_stable_radius)) return std::nullopt;
  const double price =
      price_of_sampling(design.loop, design.scene.controller->lowest_target_hz(), settings);
  if (!(price <= most_price_db)) return std::nullopt;
  const auto [disk, disk_hz] = all_leg_disk_margin(settings, least_disk_margin);
  if (!(disk >= least_disk_margin)) return std::nullopt;
  Recommendation found{.rate_hz = 1 / settings.sampling.sample_time,
                       .lead_samples = settings.law.lead_samples,
                       .roll_off_hz = {},
                       .price_db = price,
                       .disk = disk,
                       .standing = {}};
  if (settings.feedback.roll_off > 0) found.roll_off_hz = settings.feedback.roll_off / two_pi;
  return found;
}

/// Whether the page of a loop with these settings warns of none of them; if so, what stays is
/// noted.
bool goes_unwarned(const LoopSettings& settings, double target_hz, bool age_is_stated,
                   Recommendation& found) {
  DesignAnalysis analysis;
  analysis.margins.emplace();
  analysis.margins->all_disk = found.disk;
  analysis.rates = stable_rates(settings, 2 * target_hz, highest_rate_hz);
  if (!settings_warnings(settings, target_hz, analysis).empty()) return false;
  analysis.radius = spectral_radius(settings);
  analysis.misaligned_radius = misaligned_radius(settings);
  found.standing = standing_remarks(settings, target_hz, age_is_stated, analysis).warnings;
  return true;
}

}  // namespace

LoopSettings tuned(const LoopSettings& settings, double target_hz, double roll_off_targets) {
  if (roll_off_targets == 0) return settings;
  return with_roll_off(settings, two_pi * roll_off_targets * target_hz);
}

std::optional<Recommendation> recommend(const judge::LoopDesign& design) {
  return recommend(design, design.settings);
}

std::optional<Recommendation> recommend(const judge::LoopDesign& design, const LoopSettings& own) {
  const double target = design.scene.controller->lowest_target_hz();
  const bool age_is_stated = states_report_age(design.scene);
  constexpr double highest = 1e5;
  const auto tuned_at = [&](double rate, double times) {
    return tuned(at_rate(own, rate), target, times);
  };
  // What does not do at the highest rate does at no other.
  std::vector<double> tunings;
  for (const double times : tried_roll_offs) {
    if (judged(design, tuned_at(highest, times))) tunings.push_back(times);
  }
  for (double decade = 1; decade < highest && !tunings.empty(); decade *= 10) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double rate = decade * factor;
      if (rate < 4 * target) continue;
      for (const double times : tunings) {
        if (times * target > 0.4 * rate) continue;
        const LoopSettings settings = tuned_at(rate, times);
        auto found = judged(design, settings);
        if (found && goes_unwarned(settings, target, age_is_stated, *found)) return found;
      }
    }
  }
  return std::nullopt;
}

DesignAnalysis analyse(const judge::LoopDesign& design,
                       const std::function<void(const std::string&)>& progress) {
  DesignAnalysis out;
  progress("poles");
  if (design.scene.reduction) out.reduced = stable_reduced_loop(design.scene);
  const bool own = design.runs_own_law();
  if (!own) out.poles = closed_loop_poles(design.settings.plant, design.loop.gains);
  if (!design.scene.controller->law) {
    out.exact = effect_of(design, GainOrder::exact);
    out.deck = effect_of(design, GainOrder::deck);
  }
  progress("responses and their peaks");
  const ForceResponses forces(design);
  const FrequencyRange range = judge::axis_of(design, design.scene.controller->target_hz);
  const std::vector<double> round = round_frequencies(range);
  const bool paired = outputs_pair_up(design, round.front());
  for (const double hz : round) out.lines.push_back(line_at(design, forces, paired, hz));
  judge::LoopGains gains = judge::gains_of(design);
  const Eigen::Map<const Eigen::VectorXd> rows(round.data(), static_cast<Index>(round.size()));
  for (const judge::PeakRow& row : judge::peak_rows(rows, gains, design.gains.sample_rate_hz)) {
    out.peaks.push_back({row, line_at(design, forces, paired, row.peak.hz)});
  }
  out.radius = design.radius;
  out.misaligned_radius = misaligned_radius(design.settings);
  progress("margins");
  if (out.radius < largest_stable_radius) out.margins = margins(design.settings);
  if (own) {
    out.why_none = "a law of one's own has one rate";
    out.remarks = design_remarks(design, out);
    return out;
  }
  if (out.margins && out.margins->all_disk < least_disk_margin) {
    progress("what would widen the margins");
    out.widened = what_widens(design, out.margins->all_disk);
  }
  progress("rates at which it is stable");
  out.rates = stable_rates(design.settings, 2 * design.scene.controller->lowest_target_hz(),
                           highest_rate_hz);
  progress("a rate to recommend");
  out.recommended = recommend(design);
  if (!out.recommended) out.why_none = why_none_recommended(design);
  progress("warnings");
  out.remarks = design_remarks(design, out);
  return out;
}

}  // namespace stillframe::tools
