#include "controller/start_check.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <utility>

#include "controller/law.hpp"
#include "core/control/close_loop.hpp"
#include "core/control/loop_settings.hpp"
#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Complex = std::complex<double>;

namespace {

struct Change {
  std::string text;
  std::function<void(Gains&)> apply;
};

std::string shown_radius(double radius) { return formatted(radius < 2 ? "%.9f" : "%.4g", radius); }

/// Leaks worth a try, Hz: from 0.05 up in steps to what the slowest mode of the law bears, 2 zeta
/// omega_d, the eigenvalues of (I + K_P)^-1 K_I; and a tenth of the present one.
std::vector<double> candidate_leaks(const Gains& gains) {
  std::vector<double> leaks;
  if (gains.leak_hz > 0) leaks.push_back(gains.leak_hz / 10);
  const Index m = gains.n_legs();
  const MatrixXd X = MatrixXd::Identity(m, m) + gains.K_P;
  const double bound = spectral_radius(MatrixXd(X.partialPivLu().solve(gains.K_I))) / two_pi;
  for (double decade = 0.01; decade < 1e3; decade *= 10) {
    for (const double step : {1.0, 2.0, 3.0, 5.0, 7.0}) {
      const double leak = decade * step;
      if (leak < 0.05 || leak == gains.leak_hz) continue;
      if (!(leak < bound) && leak > 0.05) return leaks;
      leaks.push_back(leak);
    }
  }
  return leaks;
}

std::vector<Change> candidate_changes(const Gains& gains) {
  std::vector<Change> changes;
  // A law of one's own has all of it in its matrices, and is of one rate and one delay.
  if (gains.law) return changes;
  if (gains.realisation == Realisation::naive_pi) {
    changes.push_back({"realisation: implicit_feedthrough",
                       [](Gains& g) { g.realisation = Realisation::implicit_feedthrough; }});
  }
  // A lead that was matched to another rate or roll-off: what it is to make up for here.
  const double roll_off = two_pi * gains.roll_off_hz.value_or(0.0);
  const double lead = std::round(1e3 * matched_lead(gains.sampling(), roll_off)) / 1e3;
  if (gains.lead_samples > 0 && std::abs(gains.lead_samples - lead) > 0.01 * lead) {
    changes.push_back(
        {"lead_samples: " + formatted("%.4g", lead), [lead](Gains& g) { g.lead_samples = lead; }});
  }
  if (gains.delay_samples > 0) {
    changes.push_back({"delay_samples: 0", [](Gains& g) { g.delay_samples = 0; }});
  }
  for (const double leak : candidate_leaks(gains)) {
    changes.push_back(
        {"leak_hz: " + formatted("%.4g", leak), [leak](Gains& g) { g.leak_hz = leak; }});
  }
  for (const double factor : {2.0, 4.0, 10.0}) {
    const double rate = gains.sample_rate_hz * factor;
    changes.push_back({"sample_rate_hz: " + formatted("%g", rate),
                       [rate](Gains& g) { g.sample_rate_hz = rate; }});
  }
  if (gains.lead_samples > 0) {
    changes.push_back({"no lead_samples", [](Gains& g) { g.lead_samples = 0; }});
  }
  if (gains.roll_off_hz) {
    changes.push_back({"no roll_off_hz", [](Gains& g) { g.roll_off_hz.reset(); }});
  }
  for (const double corner : {200.0, 20.0}) {
    if (gains.roll_off_hz && *gains.roll_off_hz <= corner) continue;
    changes.push_back({"roll_off_hz: " + formatted("%.4g", corner),
                       [corner](Gains& g) { g.roll_off_hz = corner; }});
  }
  return changes;
}

void try_changes(Gains gains, const std::vector<const Change*>& changes,
                 std::vector<Remedy>& found) {
  std::string text;
  for (const Change* change : changes) {
    change->apply(gains);
    text += (text.empty() ? "" : " with ") + change->text;
  }
  const double radius = closed_loop_radius(gains);
  if (radius < largest_stable_radius) found.push_back({text, radius});
}

/// Poles count as one and the same within this: rounding spreads double ones by its square root.
constexpr double apart = 1e-7;

/// Poles of the feedback part of the loop with the law's force taken `weight` times. None where
/// they are not known.
VectorXcd loop_poles(const Gains& gains, const SampledPlant& plant, double weight) {
  DiscreteLaw law = law_from_gains(gains);
  law.C *= weight;
  law.D *= weight;
  const SampledLoop loop = close_loop(plant, law);
  const Index n = loop.A.rows() - loop.n_exogenous;
  return eigenvalues(MatrixXd(loop.A.bottomRightCorner(n, n))).value_or(VectorXcd(0));
}

bool is_among(Complex pole, const VectorXcd& poles) {
  return (poles.array() - pole).abs().minCoeff() < apart;
}

/// Why a loop is not stable.
struct Causes {
  std::vector<double> unreached_hz;  ///< as unreached_motions_hz
  bool drifts = false;               ///< a pole at 1 that the law makes
  bool others = false;
};

Causes causes_of(const Gains& gains) {
  const SampledPlant plant = sample_and_hold(gains.feedback_plant(), gains.sampling());
  const VectorXcd whole = loop_poles(gains, plant, 1), half = loop_poles(gains, plant, 0.5);
  const VectorXcd own = eigenvalues(gains.plant.A).value_or(VectorXcd(0));
  Causes causes;
  if (whole.size() == 0 || half.size() == 0 || own.size() == 0) return {{}, false, true};
  const VectorXcd held = (own * gains.sample_time()).array().exp();
  for (const Complex pole : whole) {
    if (std::abs(pole) < largest_stable_radius || pole.imag() < 0) continue;
    // A pole of the plant that stays where it is whatever part of its force the law puts in.
    if (is_among(pole, half) && is_among(pole, held)) {
      Index nearest = 0;
      (held.array() - pole).abs().minCoeff(&nearest);
      const double omega = std::abs(own(nearest).imag());
      causes.unreached_hz.push_back(omega * gains.sample_time() < apart ? 0 : omega / two_pi);
    } else if (std::abs(pole - 1.0) < 10 * apart) {
      causes.drifts = true;
    } else {
      causes.others = true;
    }
  }
  // Two of one frequency, and the double pole of a free motion, are named once.
  auto& hz = causes.unreached_hz;
  std::sort(hz.begin(), hz.end());
  hz.erase(std::unique(hz.begin(), hz.end(), [](double a, double b) { return b - a <= 1e-6 * b; }),
           hz.end());
  return causes;
}

std::string of_unreached(const std::vector<double>& motions_hz) {
  if (motions_hz.empty()) return "";
  constexpr size_t most_named = 4;
  std::string text;
  for (size_t i = 0; i < std::min(motions_hz.size(), most_named); ++i) {
    text += (i > 0 ? ", " : "") + formatted("%.4g", motions_hz[i]);
  }
  if (motions_hz.size() > most_named) {
    text += " and " + std::to_string(motions_hz.size() - most_named) + " more";
  }
  return "the law does not reach what moves at " + text +
         " Hz, and nothing else brings it to rest: no gains and no settings mend that. It needs "
         "damping in the scene" +
         (motions_hz.front() == 0 ? " (at 0 Hz a spring as well)" : "") +
         ", or a leg that acts on it";
}

std::string of_the_law(const Gains& gains, const Causes& causes) {
  if (gains.law) {
    return "Plant, the law that was brought, delay and instruments together, sampled at " +
           formatted("%g", gains.sample_rate_hz) + " Hz, do not settle.";
  }
  if (gains.realisation == Realisation::naive_pi) {
    const double gain = spectral_radius(gains.K_P);
    if (gain >= 1) {
      return "The actuator pushes on its own force sensor, so the sampled PI of `naive_pi` is a "
             "loop "
             "of gain K_P (largest eigenvalue " +
             formatted("%.4g", gain) + ") around " +
             (gains.delay_samples == 0 ? "one sample" : "two samples") + ", at every sample rate.";
    }
  }
  if (gains.leak_hz == 0 && gains.high_pass_hz == 0 && causes.drifts && !causes.others) {
    return "With leak_hz: 0 the integrator cancels the static stiffness of the legs: a constant "
           "force "
           "makes the frame drift for ever, which is a pole at 1.";
  }
  return "Plant, law, leak, roll-off and delay together, sampled at " +
         formatted("%g", gains.sample_rate_hz) + " Hz, do not settle.";
}

/// What is left where no change of a setting that was tried makes the loop stable.
std::string no_remedy(Gains gains) {
  if (gains.law) {
    return " Whoever made the law mends it: `stillframe design --mat` writes the sampled plant "
           "that "
           "it meets.";
  }
  // The two orders of the matrices, exact and deck, are each other's transposes.
  gains.K_P.transposeInPlace();
  gains.K_I.transposeInPlace();
  const bool order = closed_loop_radius(gains) < largest_stable_radius;
  return std::string(" None of the changes of one or two settings that were tried mends it: ") +
         (order ? "the other order of the matrices does (`order: exact` or `deck`)."
                : "design the gains anew, with another target.");
}

}  // namespace

double closed_loop_radius(const Gains& gains) {
  const SampledPlant plant = sample_and_hold(gains.feedback_plant(), gains.sampling());
  return spectral_radius(close_loop(plant, law_from_gains(gains)));
}

double ramp_radius(const Gains& gains) {
  const SampledPlant plant = sample_and_hold(gains.feedback_plant(), gains.sampling());
  const DiscreteLaw whole = law_from_gains(gains);
  double largest = 0;
  for (int i = 1; i < 20; ++i) {
    DiscreteLaw law = whole;
    law.C *= 0.05 * i;
    law.D *= 0.05 * i;
    largest = std::max(largest, spectral_radius(close_loop(plant, law)));
  }
  return largest;
}

double require_stable_ramp(const Gains& gains) {
  const double alone =
      spectral_radius(sample_and_hold(gains.feedback_plant(), gains.sampling()).Phi);
  // A frame that moves freely has double poles at 1, which rounding spreads by its square root.
  if (!(alone < 1 + 1e-6)) {
    throw Refusal(
        "plant: the frame does not stand by itself: without control its spectral radius is " +
        shown_radius(alone) + ", and 1 is needed, because at every fault the loop lets go of it");
  }
  const double radius = ramp_radius(gains);
  if (radius < 1) return radius;
  throw Refusal(
      "the loop is stable, but not on the way there: with a part of its gain, as in a ramp, "
      "its spectral radius is " +
      shown_radius(radius) +
      ", and below 1 is needed. A frame that does not stand by itself, or a design of "
      "little margin, does so; see `stillframe design` for the margins");
}

void require_clocked_delay(const Gains& gains, const std::string& source) {
  if (gains.delay_samples >= 1) return;
  throw InputError(source + ": delay_samples: found " + formatted("%g", gains.delay_samples) +
                   ", allowed in wall-clock mode and on a rig is 1 or more: the command of a "
                   "sample is known at the next");
}

double force_limit(const Gains& gains, const Policy& policy) {
  if (gains.force_limit_n && policy.force_limit_n) {
    return std::min(*gains.force_limit_n, *policy.force_limit_n);
  }
  if (gains.force_limit_n) return *gains.force_limit_n;
  if (policy.force_limit_n) return *policy.force_limit_n;
  throw Refusal(
      "no force limit: a wall-clock run needs one, found neither force_limit_n in the gains file "
      "nor limits.force_n in the policy; state what the actuators may be asked for, as in "
      "force_limit_n: 200 of the scene's controller block and a new design, or limits: "
      "{force_n: 200} of the policy");
}

std::vector<Remedy> find_remedies(const Gains& gains) {
  const std::vector<Change> changes = candidate_changes(gains);
  std::vector<Remedy> found;
  const auto key = [](const std::string& text) { return text.substr(0, text.find(':')); };
  // Of one setting the first value that does is enough.
  for (const Change& change : changes) {
    if (!found.empty() && key(found.back().change) == key(change.text)) continue;
    try_changes(gains, {&change}, found);
  }
  if (!found.empty()) return found;
  // An attempt takes the cube of the states: of 60 all pairs are tried, of 300 the first dozen,
  // both in seconds.
  const double states = static_cast<double>(most_loop_states(gains));
  double attempts = 4e8 / (states * states * states);
  for (size_t i = 0; i < changes.size(); ++i) {
    for (size_t j = i + 1; j < changes.size() && attempts > 0; ++j, --attempts) {
      if (key(changes[i].text) == key(changes[j].text)) continue;
      try_changes(gains, {&changes[i], &changes[j]}, found);
    }
  }
  return found;
}

std::vector<double> unreached_motions_hz(const Gains& gains) {
  return causes_of(gains).unreached_hz;
}

std::string unreached_in_words(const Gains& gains) {
  return of_unreached(causes_of(gains).unreached_hz);
}

std::string too_slow_to_tell(const Gains& gains, double radius) {
  // A pole at 1 comes out within 1e-13 of it: this one decays, but far too slowly to be sure of.
  if (radius < largest_stable_radius || !(radius < 1 - 1e-11)) return "";
  return "whether the sampled closed loop is stable cannot be told: its spectral radius is " +
         formatted("%.11f", radius) + ", and what takes longer than " +
         formatted("%.4g", gains.sample_time() / (1 - largest_stable_radius)) +
         " s to settle cannot be told from what drifts at this sample rate";
}

double require_stable(const Gains& gains) {
  const double radius = closed_loop_radius(gains);
  if (radius < largest_stable_radius) return radius;
  std::string text = "the sampled closed loop is not stable: its spectral radius is " +
                     shown_radius(radius) + ", and below 1 is needed.";
  const std::string too_slow = too_slow_to_tell(gains, radius);
  if (!too_slow.empty()) text = too_slow + ".";
  const Causes causes = causes_of(gains);
  const bool of_law =
      too_slow.empty() && (causes.drifts || causes.others || causes.unreached_hz.empty());
  if (of_law) text += " " + of_the_law(gains, causes);
  if (!causes.unreached_hz.empty()) {
    // No change of the gains file makes this loop stable, so none is tried.
    throw Refusal(text + (of_law ? " Besides, " : " Here ") + of_unreached(causes.unreached_hz) +
                  ".");
  }
  const auto remedies = find_remedies(gains);
  if (remedies.empty()) text += no_remedy(gains);
  for (size_t i = 0; i < std::min<size_t>(remedies.size(), 3); ++i) {
    text += (i == 0 ? " What mends it: " : "; or ") + remedies[i].change + " (radius " +
            shown_radius(remedies[i].radius) + ")";
  }
  throw Refusal(text);
}

}  // namespace stillframe::controller
