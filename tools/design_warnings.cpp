#include "tools/design_warnings.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/frequency_response.hpp"
#include "core/linear/singular_values.hpp"
#include "report/table.hpp"
#include "tools/design_analysis.hpp"

namespace stillframe::tools {

namespace {

using report::cell;

constexpr double two_pi = 2 * std::numbers::pi;

std::string spread(const PoleSpread& poles) {
  return cell("%.2f-%.2f of their targets", poles.lowest, poles.highest);
}

void warn_of_stability(const LoopDesign& design, const DesignAnalysis& analysis,
                       std::vector<std::string>& out) {
  if (analysis.radius < largest_stable_radius) return;
  std::string text = cell("the sampled loop is not stable (spectral radius %.9g)", analysis.radius);
  const Eigen::VectorXcd& poles = analysis.poles;
  const double real = poles.real().maxCoeff();
  if (real > 1e-9 * two_pi * design.scene.controller->lowest_target_hz()) {
    text += cell(", nor is the continuous one (largest real part %.3g 1/s)", real);
  } else {
    text += "; the continuous one is, so sampling, delay or instruments are at fault";
  }
  out.push_back(text);
}

void warn_of_order(const LoopDesign& design, const DesignAnalysis& analysis,
                   std::vector<std::string>& out) {
  // The deck's matrices are the transposed ones.
  const Eigen::MatrixXd& K_P = design.loop.gains.K_P;
  const bool coincide = (K_P - K_P.transpose()).norm() <= 1e-9 * K_P.norm();
  const PoleSpread& deck = analysis.deck;
  if (coincide) return;
  if (deck.lowest > 0.99 && deck.highest < 1.01) return;
  const bool exact = design.scene.controller->order == GainOrder::exact;
  std::string what = cell("spread the poles over %s here", spread(deck).c_str());
  if (deck.largest_real > 0) {
    what = cell("be unstable here (largest real part %+.1f 1/s)", deck.largest_real);
  }
  if (exact) {
    out.push_back("the deck's order of the matrices would " + what +
                  "; the exact order, which is used, does not");
  } else {
    out.push_back("the deck's order of the matrices, which is used, will " + what +
                  "; `order: exact` puts them on their targets");
  }
}

/// How much farther a constant force moves the frame with the law than without, in the direction
/// where that is most; infinity where nothing holds it.
double softening(const LoopDesign& design) {
  const LinearModel& plant = design.loop.plant;
  const Eigen::Index m = design.loop.n_legs;
  const SceneController& block = *design.scene.controller;
  if (block.leak_hz > 0 && block.high_pass_hz > 0) return 1;  // C(0) = 0
  // u = C(0) sigma, sigma = Y q + u: with the integrator leaking by K_I / omega_l
  //   u = -(I omega_l + K_I)^-1 K_I Y q, and u = -Y q on what the legs can do without a leak.
  const Eigen::MatrixXd Y = plant.Y_p.bottomRows(m), B = plant.B.rightCols(m);
  const Eigen::MatrixXd& K_I = design.gains.K_I;
  const double leak = two_pi * (block.leak_hz + block.high_pass_hz);
  const Eigen::MatrixXd softened =
      leak > 0 ? Eigen::MatrixXd(
                     (leak * Eigen::MatrixXd::Identity(m, m) + K_I).partialPivLu().solve(K_I * Y))
               : Y;
  const Eigen::MatrixXd K = plant.stiffness(), left = K + B * softened;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> pencil(
      (left + left.transpose()) / 2, (K + K.transpose()) / 2, Eigen::EigenvaluesOnly);
  const double stiffest = pencil.eigenvalues().cwiseAbs().maxCoeff();
  const double softest = pencil.eigenvalues().minCoeff();
  return softest > 1e-9 * stiffest ? 1 / softest : std::numeric_limits<double>::infinity();
}

/// The plant's stiffness without the legs' feedback, and what is left of it at standstill.
void warn_of_standstill(const LoopDesign& design, std::vector<std::string>& out) {
  const SceneController& block = *design.scene.controller;
  const double softer = softening(design);
  if (block.leak_hz == 0 && block.high_pass_hz == 0 && std::isinf(softer)) {
    out.push_back(
        "leak_hz is 0: nothing holds the frame at standstill; a constant force or a sensor's "
        "offset makes it drift for ever. Set leak_hz, a hundredth of target_hz for a start");
    return;
  }
  const Eigen::MatrixXd& geometric = design.loop.plant.G;
  if (geometric.norm() > 1e-9 * design.loop.plant.K.norm()) {
    // Along each motion the weight takes g = v' G v of what the loop leaves, omega_d^2 v' M v: the
    // leak has to hold 2 zeta omega_d g / omega_d^2 against it (docs/design.md).
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> pencil(
        (geometric + geometric.transpose()) / 2, design.loop.plant.M);
    const double softest = -pencil.eigenvalues().minCoeff();
    const double omega_d = two_pi * block.lowest_target_hz();
    if (softest > 0) {
      const double needed = 2 * block.damping_ratio.front() * softest / omega_d / two_pi;
      out.push_back(
          cell("preload takes up to %.1f %% off the stiffness that the loop leaves; a leak "
               "alone holds the frame from about %.2g Hz on (with a high-pass beside it "
               "see docs/design_cases.md), here leak_hz is %.2g",
               100 * softest / (omega_d * omega_d), needed, block.leak_hz));
    }
  }
  if (softer > 1.05 && std::isfinite(softer)) {
    out.push_back(
        cell("at standstill the frame gives way up to %.3g times as far as without "
             "control; high_pass_hz beside a leak would give its stiffness back",
             softer));
  }
}

void warn_of_model(const LoopDesign& design, std::vector<std::string>& out) {
  const Index n = design.loop.plant.M.rows(), m = design.loop.n_legs;
  if (n > m) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(
        design.loop.plant.K, design.loop.plant.M, Eigen::EigenvaluesOnly);
    out.push_back(
        cell("%td of the frame's %td motions are left to themselves by the %td legs; the "
             "slowest mode beyond them is at %.4g Hz",
             n - m, n, m, std::sqrt(modes.eigenvalues()(m)) / two_pi));
  }
  if (m > n) {
    out.push_back(
        cell("%td legs share the force on %td motions with the least sum of squares", m, n));
  }
  const Eigen::VectorXd frequencies = virtual_frequencies(design.loop.design.legs) / two_pi;
  const auto& targets = design.scene.controller->target_hz;
  const double highest = *std::max_element(targets.begin(), targets.end());
  if (highest > frequencies(0)) {
    out.push_back(
        cell("the target %g Hz is above the slowest mode, %.4g Hz: the loop stiffens it "
             "instead of isolating better",
             highest, frequencies(0)));
  }
}

void warn_of_margins(const DesignAnalysis& analysis, std::vector<std::string>& out) {
  if (!analysis.margins) return;
  const Margins& margins = *analysis.margins;
  if (std::isnan(margins.all_disk)) {
    out.push_back("the disk margin of all legs could not be computed: it is not known");
  } else if (margins.all_disk < least_disk_margin) {
    out.push_back(
        cell("thin margin: the disk margin of all legs is %.2f (at %.3g Hz); forces off "
             "by factors of %.2f to %.2f, or %.0f degrees, each in the worst way, make "
             "the loop unstable; a roll_off_hz with the lead_samples that match it, or less lead, "
             "widens it",
             margins.all_disk, margins.all_disk_hz, (2 - margins.all_disk) / (2 + margins.all_disk),
             (2 + margins.all_disk) / (2 - margins.all_disk),
             2 * std::atan(margins.all_disk / 2) * 180 / std::numbers::pi));
  }
}

void warn_of_late_reports(const LoopSettings& settings, const DesignAnalysis& analysis,
                          std::vector<std::string>& out) {
  if (analysis.misaligned_radius < largest_stable_radius) return;
  out.push_back(
      cell("if the applied force were reported one sample late, the loop would be "
           "unstable (radius %.4g)%s",
           analysis.misaligned_radius,
           settings.feedback.roll_off > 0 ? "" : "; roll_off_hz makes it forgive more"));
}

/// Where the controlled frame moves more than the passive one.
void warn_of_amplification(const LoopSettings& settings, double target_hz,
                           const DesignAnalysis& analysis, std::vector<std::string>& out) {
  if (!(analysis.radius < largest_stable_radius)) return;
  const SampledPlant plant = sample_and_hold(settings.plant, settings.sampling);
  const SampledLoop passive = open_loop(plant), controlled = close_loop(plant, law_of(settings));
  double from = 0, to = 0, worst = 1;
  const double nyquist = 0.5 / settings.sampling.sample_time;
  for (const double hz : logarithmic_frequencies(target_hz, nyquist, 200)) {
    const double open = singular_values(transfer(passive, two_pi * hz))(0);
    const double ratio = singular_values(transfer(controlled, two_pi * hz))(0) / open;
    if (ratio > 1.05) {
      if (from == 0) from = hz;
      to = hz;
      worst = std::max(worst, ratio);
    }
  }
  if (from > 0) {
    out.push_back(
        cell("between %.3g and %.3g Hz the controlled frame moves up to %.1f dB more than "
             "the passive one: the price of sampling; a higher rate moves it up",
             from, to, 20 * std::log10(worst)));
  }
}

void warn_of_rates(double rate, double target_hz, const DesignAnalysis& analysis,
                   std::vector<std::string>& out) {
  for (const auto& [slowest, fastest] : analysis.rates) {
    if (rate < slowest || rate > fastest) continue;
    if (rate > fastest / 2 && fastest < 1e5) {
      out.push_back(cell("the loop is unstable again above %.4g Hz", fastest));
    }
  }
  if (target_hz > rate / 20) {
    out.push_back(
        "target_hz is above a twentieth of the sample rate: the sampled loop is far from "
        "the continuous design");
  }
}

}  // namespace

std::string left_out_of_analysis(const Instruments& instruments) {
  std::string what;
  const auto add = [&what](bool there, const char* name) {
    if (there) what += (what.empty() ? "" : ", ") + std::string(name);
  };
  add(instruments.hysteresis.has_value(), "hysteresis");
  add(std::isfinite(instruments.force_rate_limit), "force_rate_limit_n_per_s");
  add(instruments.force_sensors.has_value(), "force_sensors");
  if (what.empty()) return "";
  return "the plant simulator alone has these instruments, the analysis leaves them out: " + what;
}

std::vector<std::string> settings_warnings(const LoopSettings& settings, double target_hz,
                                           const DesignAnalysis& analysis) {
  std::vector<std::string> out;
  warn_of_margins(analysis, out);
  warn_of_rates(1 / settings.sampling.sample_time, target_hz, analysis, out);
  return out;
}

std::vector<std::string> standing_warnings(const LoopSettings& settings, double target_hz,
                                           const DesignAnalysis& analysis) {
  std::vector<std::string> out;
  warn_of_late_reports(settings, analysis, out);
  warn_of_amplification(settings, target_hz, analysis, out);
  return out;
}

std::vector<std::string> design_warnings(const LoopDesign& design, const DesignAnalysis& analysis) {
  std::vector<std::string> out;
  warn_of_stability(design, analysis, out);
  warn_of_order(design, analysis, out);
  warn_of_standstill(design, out);
  warn_of_model(design, out);
  const double target_hz = design.scene.controller->lowest_target_hz();
  for (const auto& warnings : {settings_warnings(design.settings, target_hz, analysis),
                               standing_warnings(design.settings, target_hz, analysis)}) {
    out.insert(out.end(), warnings.begin(), warnings.end());
  }
  const std::string left_out = left_out_of_analysis(design.scene.instruments);
  if (!left_out.empty()) out.push_back(left_out);
  return out;
}

}  // namespace stillframe::tools
