#include "core/control/robustness/evaluator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <set>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/golden_section.hpp"
#include "core/numerics/singular_values.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/systems/frequency_sweep.hpp"
#include "core/systems/resonances.hpp"

namespace stillframe::robustness {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXd;

VectorXd outcome_frequencies_hz(double target_hz, double sample_rate_hz) {
  std::set<double> all;
  const double from = target_hz / 50, to = 0.45 * sample_rate_hz;
  const int steps = std::max(1, static_cast<int>(std::ceil(10 * std::log10(to / from))));
  for (int i = 0; i <= steps; ++i) {
    const std::string digits = formatted("%.3g", from * std::pow(to / from, double(i) / steps));
    all.insert(std::strtod(digits.c_str(), nullptr));
  }
  for (const double f : {1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0}) {
    if (f < sample_rate_hz / 2) all.insert(f);
  }
  VectorXd frequencies(static_cast<Index>(all.size()));
  std::copy(all.begin(), all.end(), frequencies.begin());
  return frequencies;
}

double least_damping(const Eigen::VectorXcd& poles) {
  double least = 1;
  for (const Complex& z : poles) {
    const double modulus = std::abs(z);
    // Poles of commands on their way are 0 but for rounding.
    if (modulus < 1e-12) continue;
    const double decay = -std::log(modulus);
    least = std::min(least, decay / std::hypot(decay, std::arg(z)));
  }
  return least;
}

namespace {

/// The largest singular value of T. A feed-forward is part of no plant and moves no pole: with its
/// states in the loop a frequency takes ten times as long as by T_fb + H Theta.
class LargestSingularValue {
 public:
  LargestSingularValue(const SampledLoop& loop, const FeedForward& filter)
      : sweep_(proper_system({loop.A, loop.B, loop.C, loop.D})), filter_(filter) {}

  const Eigen::VectorXcd& poles() const { return sweep_.poles(); }

  /// At each of the angles omega T_s.
  VectorXd at(const std::vector<double>& angles) {
    const Index n_y = sweep_.n_outputs(), n_w = sweep_.n_inputs() - filter_.weights.rows();
    std::vector<MatrixXcd> T(angles.size());
    MatrixXcd all(n_y, sweep_.n_inputs());
    for (size_t i = 0; i < angles.size(); ++i) {
      const Complex z = std::polar(1.0, angles[i]);
      sweep_.evaluate(z, all);
      T[i] = all.leftCols(n_w);
      if (!filter_.empty()) T[i] += all.rightCols(filter_.weights.rows()) * response_of(filter_, z);
    }
    Eigen::MatrixXd values(std::min(n_y, n_w), static_cast<Index>(angles.size()));
    SingularValues(n_y, n_w).compute(T.data(), values.cols(), values);
    return values.row(0);
  }

 private:
  FrequencySweep sweep_;
  const FeedForward& filter_;
};

/// The index of the frequency (ascending, Hz) that is nearest to another by their ratio.
Index nearest(const VectorXd& frequencies_hz, double hz) {
  const auto above = std::lower_bound(frequencies_hz.begin(), frequencies_hz.end(), hz);
  if (above == frequencies_hz.begin()) return 0;
  const Index i = above - frequencies_hz.begin();
  if (above == frequencies_hz.end()) return i - 1;
  return hz * hz < frequencies_hz(i) * frequencies_hz(i - 1) ? i - 1 : i;
}

/// The peak of T between two angles, by golden sections: to 0.618^10 of their distance, and T to
/// the square of that. At least `found`.
double refined_peak(LargestSingularValue& largest, double from, double to, double found) {
  double highest = found;
  const auto value = [&](double angle) {
    const double there = largest.at({angle})(0);
    highest = std::max(highest, there);
    return there;
  };
  golden_section(value, from, to, 10);
  return highest;
}

std::optional<Eigen::VectorXcd> feedback_poles(const SampledLoop& loop) {
  const Index n = loop.A.rows() - loop.n_exogenous;
  return eigenvalues(Eigen::MatrixXd(loop.A.bottomRightCorner(n, n)));
}

/// What an error is about, without the numbers of this plant.
std::string heading(const std::string& message) {
  return message.substr(0, std::min(message.find(": "), message.find("; ")));
}

}  // namespace

SampledPlant Evaluator::plant_of(const VectorXd& values) const {
  return sampled(perturbed(settings_.scene, settings_.sampling, settings_.parameters, values));
}

SampledLoop Evaluator::loop_of(const VectorXd& values) const {
  return settings_.feed_forward.empty()
             ? close_loop(plant_of(values), settings_.law)
             : close_loop_with_added_force(plant_of(values), settings_.law);
}

Outcome Evaluator::operator()(const VectorXd& values, Want want) const {
  Outcome outcome;
  SampledLoop loop;
  try {
    loop = loop_of(values);
  } catch (const Refusal& refusal) {
    outcome.failure = heading(refusal.what());
    return outcome;
  } catch (const InputError& error) {
    outcome.failure = error.what();
    return outcome;
  }
  if (!loop.A.allFinite() || !loop.B.allFinite() || !loop.C.allFinite() || !loop.D.allFinite()) {
    outcome.failure = "numbers of the model overflow";
    return outcome;
  }
  const double T_s = loop.sample_time;
  const auto found = feedback_poles(loop);
  if (!found) {
    outcome.failure = "the poles of the loop are not found";
    return outcome;
  }
  const Eigen::VectorXcd& poles = *found;
  outcome.radius = poles.cwiseAbs().maxCoeff();
  outcome.decay = -std::log(outcome.radius) / T_s;
  outcome.damping = least_damping(poles);
  outcome.verdict = outcome.radius < largest_stable_radius ? Outcome::Verdict::stable
                                                           : Outcome::Verdict::unstable;
  if (want == Want::poles || outcome.verdict == Outcome::Verdict::unstable) return outcome;

  const VectorXd& f = settings_.frequencies_hz;
  const double radians = two_pi * T_s;
  std::vector<double> angles;
  for (const double hz : f) angles.push_back(radians * hz);
  // A resonance is sharpest at the angle of its pole, between the frequencies of any grid.
  std::vector<Complex> at_poles;
  for (const Complex& z : poles) {
    if (z.imag() > 0 && std::arg(z) >= angles.front()) at_poles.push_back(z);
  }
  for (const Complex& z : at_poles) angles.push_back(std::arg(z));
  LargestSingularValue largest(loop, settings_.feed_forward);
  const VectorXd gains = largest.at(angles);
  outcome.gain = gains.head(f.size());
  outcome.highest = outcome.gain;
  const auto raise = [&](Complex z, double gain) {
    double& highest = outcome.highest(nearest(f, std::arg(z) / radians));
    highest = std::max(highest, gain);
  };
  for (size_t i = 0; i < at_poles.size(); ++i) {
    raise(at_poles[i], gains(f.size() + static_cast<Index>(i)));
  }
  Index at = 0;
  outcome.peak = gains.maxCoeff(&at);
  if (at >= f.size()) {
    const Complex z = at_poles[static_cast<size_t>(at - f.size())];
    // Among poles that are near it is beside all of them.
    const double width = std::abs(std::log(std::abs(z)));
    outcome.peak = refined_peak(largest, std::arg(z) - width, std::arg(z) + width, outcome.peak);
    raise(z, outcome.peak);
  } else if (!settings_.feed_forward.empty() && at > 0) {
    // What a feed-forward leaves rises between the frequencies at no pole.
    const double after = at + 1 < f.size() ? radians * f(at + 1) : std::numbers::pi;
    outcome.peak = refined_peak(largest, radians * f(at - 1), after, outcome.peak);
    outcome.highest(at) = std::max(outcome.highest(at), outcome.peak);
  }
  return outcome;
}

Evaluator::Curve Evaluator::curve(const VectorXd& values, const VectorXd& frequencies_hz,
                                  bool with_resonances) const {
  const SampledLoop loop = loop_of(values);
  LargestSingularValue largest(loop, settings_.feed_forward);
  Curve found{frequencies_hz, {}};
  if (with_resonances) {
    const auto where = resonances(largest.poles(), loop.sample_time);
    found.frequencies_hz = stillframe::with_resonances(frequencies_hz, where);
  }
  std::vector<double> angles;
  for (const double hz : found.frequencies_hz) angles.push_back(two_pi * hz * loop.sample_time);
  found.gain = largest.at(angles);
  return found;
}

}  // namespace stillframe::robustness
