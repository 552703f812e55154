#include "tools/design_warnings.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "controller/start_check.hpp"
#include "core/control/continuous_loop.hpp"
#include "core/errors/formatted.hpp"
#include "core/numerics/decibels.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/singular_values.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/yaml/reader.hpp"
#include "judge/aim.hpp"
#include "tools/design_amplification.hpp"
#include "tools/design_analysis.hpp"

namespace stillframe::tools {

namespace {

std::string spread(const PoleSpread& poles) {
  return formatted("%.2f-%.2f of their targets", poles.lowest, poles.highest);
}

void warn_of_stability(const judge::LoopDesign& design, const DesignAnalysis& analysis,
                       std::vector<std::string>& out) {
  if (analysis.radius < largest_stable_radius) return;
  const std::string slow = controller::too_slow_to_tell(design.gains, analysis.radius);
  if (!slow.empty()) return out.push_back(slow);
  std::string text =
      formatted("the sampled loop is not stable (spectral radius %.9g)", analysis.radius);
  if (design.runs_own_law()) {
    out.push_back(text);
    const std::string unreached = controller::unreached_in_words(design.gains);
    if (!unreached.empty()) out.push_back(unreached);
    return;
  }
  const Eigen::VectorXcd& poles = analysis.poles;
  const double real = poles.real().maxCoeff();
  const double rounding = 1e-9 * two_pi * design.scene.controller->lowest_target_hz();
  if (real > rounding) {
    text += formatted(", nor is the continuous one (largest real part %.3g 1/s)", real);
  } else if (real > -rounding) {
    text += ", nor does the continuous one settle";
  } else {
    text += "; the continuous one is, so sampling, delay or instruments are at fault";
  }
  out.push_back(text);
  const std::string unreached = controller::unreached_in_words(design.gains);
  if (!unreached.empty()) out.push_back(unreached);
}

void warn_of_order(const judge::LoopDesign& design, const DesignAnalysis& analysis,
                   std::vector<std::string>& out) {
  // The deck's matrices are the transposed ones.
  if (!analysis.deck) return;
  const Eigen::MatrixXd& K_P = design.loop.gains.K_P;
  const bool coincide = (K_P - K_P.transpose()).norm() <= 1e-9 * K_P.norm();
  const PoleSpread& deck = *analysis.deck;
  if (coincide) return;
  if (deck.lowest > 0.99 && deck.highest < 1.01) return;
  const bool exact = design.scene.controller->order == GainOrder::exact;
  const bool unstable = deck.largest_real > 0;
  const std::string what =
      unstable ? formatted("be unstable here (largest real part %+.1f 1/s)", deck.largest_real)
               : formatted("spread the poles over %s here", spread(deck).c_str());
  const std::string order = "the deck's order of the matrices (M^-1 K in place of K M^-1)";
  if (exact) {
    out.push_back(order + " would " + what + "; the exact order, which is used, " +
                  (unstable ? "is not" : "does not"));
  } else {
    out.push_back(order + ", which is used, will " + what +
                  "; `order: exact` puts the poles on their targets");
  }
}

/// What holds the frame at standstill, symmetric, N per unit of dof: its stiffness and what the law
/// leaves of that of the legs with an integrator that leaks by `leak` (rad/s). With K_I / omega_l
///   u = C(0) sigma, sigma = Y q + u: u = -(I omega_l + K_I)^-1 K_I Y q,
/// and u = -Y q on what the legs can do without a leak.
Eigen::MatrixXd stiffness_at_standstill(const judge::LoopDesign& design, double leak) {
  const LinearModel& plant = design.loop.plant;
  const Eigen::Index m = design.loop.n_legs;
  const Eigen::MatrixXd Y = plant.Y_p.bottomRows(m), B = plant.B.rightCols(m);
  const Eigen::MatrixXd& K_I = design.gains.K_I;
  const Eigen::MatrixXd softened =
      leak > 0 ? Eigen::MatrixXd(
                     (leak * Eigen::MatrixXd::Identity(m, m) + K_I).partialPivLu().solve(K_I * Y))
               : Y;
  const Eigen::MatrixXd left = plant.stiffness() + B * softened;
  return (left + left.transpose()) / 2;
}

/// How much farther a constant force moves the frame with the law than without, in the direction
/// where that is most; infinity where nothing holds it.
double softening(const judge::LoopDesign& design) {
  const SceneController& block = *design.scene.controller;
  if (block.leak_hz > 0 && block.high_pass_hz > 0) return 1;  // C(0) = 0
  const Eigen::MatrixXd K = design.loop.plant.stiffness();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> pencil(
      stiffness_at_standstill(design, two_pi * (block.leak_hz + block.high_pass_hz)),
      (K + K.transpose()) / 2, Eigen::EigenvaluesOnly);
  const double stiffest = pencil.eigenvalues().cwiseAbs().maxCoeff();
  const double softest = pencil.eigenvalues().minCoeff();
  return softest > 1e-9 * stiffest ? 1 / softest : infinity;
}

/// The leak (rad/s) from which on it alone holds the frame at standstill, to a thousandth; 0 if the
/// least leak of any use does, infinity if none does. Parts that lean on others but on no leg count
/// with what holds them: the law takes nothing of that away.
double least_leak(const judge::LoopDesign& design) {
  const double omega_d = two_pi * design.scene.controller->lowest_target_hz();
  const auto holds = [&](double leak) {
    return stiffness_at_standstill(design, leak).llt().info() == Eigen::Success;
  };
  double low = 1e-4 * omega_d, high = low;
  if (holds(low)) return 0;
  while (!holds(high)) {
    low = high;
    high *= 4;
    if (high > 1e6 * omega_d) return infinity;
  }
  while (high > 1.001 * low) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? high : low) = middle;
  }
  return high;
}

/// Leaks (rad/s) with which the continuous law without a high-pass holds the frame in motion too.
struct Window {
  double from = 0, to = 0;
};

/// `from`: the leak that holds it at standstill. None if no leak does; to: infinity if any that is
/// larger does.
std::optional<Window> leaks_that_hold(const judge::LoopDesign& design, double from) {
  ForceFeedback feedback = continuous_law(design.settings);
  feedback.high_pass = 0;
  const double omega_d = two_pi * design.scene.controller->lowest_target_hz();
  const auto holds = [&](double leak) {
    feedback.leak = leak;
    return closed_loop_poles(design.settings.plant, feedback).real().maxCoeff() < -1e-9 * omega_d;
  };
  // The edge between two leaks, to a thousandth.
  const auto edge = [&](double low, double high) {
    const bool held = holds(low);
    while (high > 1.001 * low) {
      const double middle = std::sqrt(low * high);
      (holds(middle) == held ? low : high) = middle;
    }
    return high;
  };
  constexpr double step = 1.1;
  const double most = 1e3 * std::max(from, omega_d);
  double leak = 1.001 * from;
  std::optional<Window> window;
  if (holds(leak)) window = {from, leak};
  for (; leak < most; leak *= step) {
    const bool next = holds(step * leak);
    if (!window && next) {
      window = {edge(leak, step * leak), 0};
    } else if (window && !next) {
      window->to = edge(leak, step * leak);
      return window;
    }
  }
  if (window) window->to = infinity;
  return window;
}

/// The plant's stiffness without the legs' feedback, and what is left of it at standstill.
void warn_of_standstill(const judge::LoopDesign& design, std::vector<std::string>& out) {
  const SceneController& block = *design.scene.controller;
  const double softer = softening(design);
  if (block.leak_hz == 0 && block.high_pass_hz == 0 && std::isinf(softer)) {
    out.push_back(
        "leak_hz is 0: nothing holds the frame at standstill; a constant force or a sensor's "
        "offset makes it drift for ever. Set leak_hz, a hundredth of target_hz for a start");
    return;
  }
  if (design.loop.plant.G.norm() > 1e-9 * design.loop.plant.K.norm()) {
    const double needed = least_leak(design);
    if (needed > 0 && std::isfinite(needed)) {
      // Of one motion alone the weight takes g of what the loop leaves, omega_d^2 m, and the leak
      // has to hold 2 zeta omega_d g / (omega_d^2 m) against it (docs/design.md).
      const double omega_d = two_pi * block.lowest_target_hz();
      const double taken = needed / (2 * block.damping_ratio.front() * omega_d);
      const std::string much = formatted(
          "the weight and preload on the legs take up to %.1f %% off the stiffness that the loop "
          "leaves; ",
          100 * taken);
      const std::optional<Window> window = leaks_that_hold(design, needed);
      if (!window) {
        out.push_back(much + "no leak alone holds the frame" +
                      (taken > 1
                           ? formatted("; a target above about %.2g Hz leaves more than they take",
                                       block.lowest_target_hz() * std::sqrt(taken))
                           : ""));
      } else {
        out.push_back(
            much +
            formatted("a leak alone holds the frame from about %.2g Hz", window->from / two_pi) +
            (std::isinf(window->to) ? " on" : formatted(" to %.2g Hz", window->to / two_pi)) +
            formatted(" (with a high-pass beside it see docs/design_cases.md), here leak_hz is "
                      "%.2g",
                      block.leak_hz));
      }
    }
  }
  if (softer > 1.05 && std::isfinite(softer)) {
    out.push_back(
        formatted("at standstill the frame gives way up to %.3g times as far as without "
                  "control; high_pass_hz beside a leak would give its stiffness back",
                  softer));
  }
}

/// Motions that the continuous law hardly damps, slowest first.
std::string hardly_damped(const Eigen::VectorXcd& poles, double ratio) {
  constexpr size_t n_named = 4;
  std::string text;
  size_t n = 0;
  double highest = 0;
  for (const std::complex<double> pole : poles) {
    // An undamped one may come out on either side of the axis.
    const double found = -pole.real() / std::abs(pole), hz = pole.imag() / two_pi;
    if (hz <= 0 || found < -1e-9 || found >= ratio) continue;
    if (n < n_named) {
      text += formatted(n == 0 ? "%.4g Hz (damping ratio %.2g)" : ", %.4g Hz (%.2g)", hz,
                        std::max(found, 0.0));
    }
    highest = hz;
    ++n;
  }
  if (n > n_named) text += formatted(" and %zu more, up to %.4g Hz", n - n_named, highest);
  return text;
}

void warn_of_motions(const judge::LoopDesign& design, const DesignAnalysis& analysis,
                     std::vector<std::string>& out) {
  const Index n = design.loop.plant.M.rows(), m = design.loop.n_legs;
  const auto& targets = design.scene.controller->damping_ratio;
  const double ratio = 0.1 * *std::min_element(targets.begin(), targets.end());
  const std::string left = hardly_damped(analysis.poles, ratio);
  std::string text;
  if (n > m) text = formatted("%td leg(s) act on as many of the frame's %td motions; ", m, n);
  if (!left.empty()) {
    out.push_back(text + "hardly damped by the law, without sampling: " + left);
  } else if (n > m) {
    out.push_back(text + formatted("the law leaves none with a damping ratio below %.2g", ratio));
  }
  if (m > n) {
    out.push_back(
        formatted("%td legs share the force on %td motions with the least sum of squares", m, n));
  }
}

/// Natural frequency, Hz, of the slowest mode of the frame in whose stiffness the legs have a part:
/// a tenth of what they have in any.
double slowest_on_legs(const ControlLoop& loop) {
  const Eigen::MatrixXd K = loop.plant.stiffness();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes((K + K.transpose()) / 2,
                                                                        loop.plant.M);
  const Eigen::MatrixXd& V = modes.eigenvectors();
  const Eigen::MatrixXd e = -loop.plant.B.rightCols(loop.n_legs).transpose() * V,
                        sigma = loop.plant.Y_p.bottomRows(loop.n_legs) * V;
  // A motion without stiffness strains no leg.
  const Eigen::VectorXd squares =
      modes.eigenvalues().cwiseAbs().cwiseMax(std::numeric_limits<double>::min());
  const Eigen::VectorXd part =
      e.cwiseProduct(sigma).colwise().sum().transpose().cwiseQuotient(squares);
  Index i = 0;
  while (part(i) < 0.1 * part.maxCoeff()) ++i;
  return std::sqrt(squares(i)) / two_pi;
}

void warn_of_targets(const judge::LoopDesign& design, const std::vector<double>& targets,
                     std::vector<std::string>& out) {
  constexpr const char* stiffened = ": the loop stiffens it instead of isolating better";
  if (targets.size() == 1) {
    const double slowest = slowest_on_legs(design.loop);
    if (targets.front() <= slowest) return;
    return out.push_back(
        formatted("the target %g Hz is above the slowest mode on the legs, %.4g Hz%s",
                  targets.front(), slowest, stiffened));
  }
  const Eigen::VectorXd modes = virtual_frequencies(design.loop.design.legs) / two_pi;
  for (size_t i = 0; i < targets.size(); ++i) {
    const double mode = modes(static_cast<Index>(i));
    if (targets[i] <= mode) continue;
    out.push_back(formatted("the target %g Hz is above virtual mode %zu, %.4g Hz%s", targets[i],
                            i + 1, mode, stiffened));
  }
}

/// Where the loop that runs moves more than what was aimed at.
void warn_of_aim(const judge::LoopDesign& design, const DesignAnalysis& analysis,
                 std::vector<std::string>& out) {
  // A feed-forward is designed to stay within 3 dB; twice what was aimed at is no longer that.
  constexpr double near_db = 3, noted_db = 6, points = 100, edge = 0.1, up_to_targets = 4;
  if (!(analysis.radius < largest_stable_radius)) return;
  const SceneController& block = *design.scene.controller;
  const double target_hz = judge::lowest_aim_hz(block), half = 0.5 / design.gains.sample_time();
  const bool forward = !design.gains.feed_forward.filter.empty();
  const double to = forward ? block.feed_forward->to_hz : up_to_targets * target_hz;
  const ControlLoop aim = judge::aim_of(design);
  const auto worst = [&](double from, double until, auto&& allowed) {
    std::pair<double, double> found{-infinity, 0};
    if (!(from < until)) return found;
    for (int i = 0; i <= points; ++i) {
      const double hz = from * std::pow(until / from, i / points);
      const double over =
          decibels(singular_values(transfer(design.closed, two_pi * hz))(0) / allowed(hz));
      found = std::max(found, {over, hz});
    }
    return found;
  };
  const auto [over_db, over_hz] = worst(forward ? block.feed_forward->corner_hz : edge * target_hz,
                                        std::min(to, half), [&](double hz) {
                                          return singular_values(aim.closed({0, two_pi * hz}))(0);
                                        });
  if (over_db > (forward ? near_db : noted_db)) {
    out.push_back(
        formatted("up to %.4g Hz the frame moves up to %.1f dB more than what is aimed at, "
                  "the target %g Hz without sampling and roll-off (at %.3g Hz)",
                  to, over_db, target_hz, over_hz));
  }
  if (!forward) return;
  const auto [above_db, above_hz] = worst(
      1.5 * to, half, [&](double) { return std::pow(10, block.feed_forward->at_most_db / 20); });
  if (above_db > near_db) {
    out.push_back(
        formatted("from %.4g Hz on the frame moves up to %.1f dB more than the at_most_db: %g "
                  "that the feed-forward is to keep (at %.3g Hz)",
                  1.5 * to, above_db, block.feed_forward->at_most_db, above_hz));
  }
}

/// Legs along which no input moves the floor. The mass stands still against a floor that shakes
/// fast, and an input along a leg elongates it by as much as the foot moves then, whatever the dofs
/// are: the static part of what is read less what the masses take up.
void warn_of_inputs(const judge::LoopDesign& design, std::vector<std::string>& out) {
  const LinearModel& plant = design.loop.plant;
  const Index m = design.loop.n_legs, n_w = design.loop.n_w;
  const Eigen::MatrixXd follow = plant.M.ldlt().solve(plant.M_r.leftCols(n_w));
  const Eigen::MatrixXd Y = plant.Y_p.bottomRows(m);
  const Eigen::MatrixXd read = plant.R_p.bottomLeftCorner(m, n_w) - Y * follow;
  std::string legs;
  for (Index i = 0; i < m; ++i) {
    // Stress over elongation.
    const double stiffness = Y.row(i).norm() / plant.B.col(plant.B.cols() - m + i).norm();
    constexpr double hardly = 0.1;  // 84 degrees
    if (read.row(i).cwiseAbs().maxCoeff() >= hardly * stiffness) continue;
    legs += (legs.empty() ? "" : ", ") + design.gains.legs[static_cast<size_t>(i)];
  }
  if (legs.empty()) return;
  out.push_back("no input moves the floor along " + legs +
                ": what comes through there is in no number of this page");
}

/// What a law of one's own does where the loop is cut: while a force is limited.
void warn_of_own_states(const judge::LoopDesign& design, std::vector<std::string>& out) {
  const double radius = spectral_radius(law_of(design.settings).A);
  if (radius < largest_stable_radius) return;
  out.push_back(formatted(
      "the law's own states do not decay (spectral radius %.9g): while a force is limited "
      "they run on, and what they have grown to is asked for when it no longer is",
      radius));
}

void warn_of_margins(const DesignAnalysis& analysis, std::vector<std::string>& out) {
  if (!analysis.margins) return;
  const Margins& margins = *analysis.margins;
  if (std::isnan(margins.all_disk)) {
    out.push_back("the disk margin of all legs could not be computed: it is not known");
  } else if (margins.all_disk < least_disk_margin) {
    out.push_back(
        formatted("thin margin: the disk margin of all legs is %.2f (at %.3g Hz); forces off "
                  "by factors of %.2f to %.2f, or %.0f degrees, each in the worst way, make "
                  "the loop unstable",
                  margins.all_disk, margins.all_disk_hz,
                  (2 - margins.all_disk) / (2 + margins.all_disk),
                  (2 + margins.all_disk) / (2 - margins.all_disk),
                  2 * std::atan(margins.all_disk / 2) * 180 / std::numbers::pi) +
        (analysis.widened.empty() ? "" : "; " + analysis.widened));
  }
}

std::string of_late_reports(const LoopSettings& settings, bool age_is_stated,
                            const DesignAnalysis& analysis) {
  if (analysis.misaligned_radius < largest_stable_radius) return "";
  return formatted(
      "if the applied force were reported one sample late%s, the loop would be "
      "unstable (radius %.4g)%s%s",
      age_is_stated ? ", which the scene says it is not" : "", analysis.misaligned_radius,
      settings.own || settings.feedback.roll_off > 0 || age_is_stated
          ? ""
          : "; roll_off_hz makes it forgive more",
      age_is_stated ? "" : "; `instruments: {report_age_samples: 0}` states that it is not");
}

void warn_of_rates(double rate, double target_hz, const DesignAnalysis& analysis,
                   std::vector<std::string>& out) {
  for (const auto& [slowest, fastest] : analysis.rates) {
    if (rate < slowest || rate > fastest) continue;
    if (rate > fastest / 2 && fastest < 1e5) {
      out.push_back(formatted("the loop is unstable again above %.4g Hz", fastest));
    }
  }
  if (target_hz > rate / 20) {
    out.push_back(
        "target_hz is above a twentieth of the sample rate: the sampled loop is far from "
        "the continuous design");
  }
}

}  // namespace

namespace {

std::string alone_in_plant(const std::string& what) {
  return what.empty() ? ""
                      : "the plant simulator alone has these instruments, the analysis leaves them "
                        "out: " +
                            what;
}

/// Noise is in the budget, to which it adds; all else changes what the loop does.
bool only_add_noise(const ForceSensorErrors& errors) {
  const auto none = [](const std::vector<double>& each) {
    return std::ranges::all_of(each, [](double value) { return value == 0; });
  };
  return none(errors.offset) && none(errors.drift) && errors.random_walk == 0 &&
         errors.quantisation == 0 && std::isinf(errors.range);
}

}  // namespace

std::string left_out_of_analysis(const Instruments& instruments) {
  std::string what;
  const auto add = [&what](bool there, const char* name) {
    if (there) what += (what.empty() ? "" : ", ") + std::string(name);
  };
  add(instruments.hysteresis.has_value(), "hysteresis");
  add(std::isfinite(instruments.force_rate_limit), "force_rate_limit_n_per_s");
  add(instruments.force_sensors && !only_add_noise(*instruments.force_sensors), "force_sensors");
  return alone_in_plant(what);
}

bool states_report_age(const Scene& scene) {
  const auto block = YamlReader::from_text(scene.text, scene.file).find("instruments");
  return block && block->find("report_age_samples");
}

std::vector<std::string> settings_warnings(const LoopSettings& settings, double target_hz,
                                           const DesignAnalysis& analysis) {
  std::vector<std::string> out;
  warn_of_margins(analysis, out);
  warn_of_rates(1 / settings.sampling.sample_time, target_hz, analysis, out);
  return out;
}

Remarks standing_remarks(const LoopSettings& settings, double target_hz, bool age_is_stated,
                         const DesignAnalysis& analysis) {
  Remarks out;
  const std::string late = of_late_reports(settings, age_is_stated, analysis);
  if (!late.empty()) (age_is_stated ? out.notes : out.warnings).push_back(late);
  if (analysis.radius < largest_stable_radius) out.add(amplification(settings, target_hz));
  return out;
}

Remarks design_remarks(const judge::LoopDesign& design, const DesignAnalysis& analysis) {
  Remarks out;
  std::vector<std::string>& warnings = out.warnings;
  warn_of_stability(design, analysis, warnings);
  if (design.runs_own_law()) {
    warn_of_own_states(design, warnings);
  } else {
    warn_of_order(design, analysis, warnings);
    warn_of_standstill(design, warnings);
    warn_of_motions(design, analysis, warnings);
    warn_of_targets(design, design.scene.controller->target_hz, warnings);
  }
  if (const auto& forward = design.scene.controller->feed_forward; forward && forward->target_hz) {
    warn_of_targets(design, {*forward->target_hz}, warnings);
  }
  warn_of_aim(design, analysis, warnings);
  warn_of_inputs(design, warnings);
  const double target_hz = judge::lowest_aim_hz(*design.scene.controller);
  out.add({settings_warnings(design.settings, target_hz, analysis), {}});
  out.add(standing_remarks(design.settings, target_hz, states_report_age(design.scene), analysis));
  const std::string left_out = left_out_of_analysis(design.scene.instruments);
  if (!left_out.empty()) warnings.push_back(left_out);
  return out;
}

}  // namespace stillframe::tools
