#include "tools/design_amplification.hpp"

#include <algorithm>
#include <cmath>

#include "core/control/continuous_loop.hpp"
#include "core/errors/formatted.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/numerics/decibels.hpp"
#include "core/numerics/two_pi.hpp"
#include "core/systems/resonances.hpp"

namespace stillframe::tools {

namespace {

using Complex = std::complex<double>;
using Eigen::Index;

constexpr double noted_ratio = 1.05;
/// Part of the floor, -26 dB: what is left of it there is nobody's concern.
constexpr double little = 0.05;
/// Below this ratio the damping is no work of the law.
constexpr double light_damping = 0.1;

/// Neighbouring frequencies at which the frame moves more, and by what factor at most.
struct Range {
  double from_hz = 0, to_hz = 0, worst = 0;
};

/// How much is left where it counts, for a note.
std::string at_most_db(double largest) {
  return formatted(", but no more than %.1f dB of its floor", decibels(largest));
}

/// Takes frequencies in rising order, with the factor where it counts and 0 where it does not.
class Ranges {
 public:
  void add(double hz, double factor) {
    if (factor > 0 && !open_) found_.push_back({.from_hz = hz, .to_hz = hz, .worst = factor});
    open_ = factor > 0;
    if (!open_) return;
    found_.back().to_hz = hz;
    found_.back().worst = std::max(found_.back().worst, factor);
  }

  bool empty() const { return found_.empty(); }

  Range worst() const {
    return *std::max_element(found_.begin(), found_.end(),
                             [](const Range& a, const Range& b) { return a.worst < b.worst; });
  }

  std::string text() const {
    const auto [from, to, factor] = worst();
    std::string text = formatted(
        "between %.3g and %.3g Hz the controlled frame moves up to %.1f dB more than the "
        "passive one",
        from, to, decibels(factor));
    if (found_.size() > 1)
      text += formatted(" (and less so in %zu other range(s))", found_.size() - 1);
    return text;
  }

 private:
  std::vector<Range> found_;
  bool open_ = false;
};

/// Why the law moves the frame more in this range, without sampling.
std::string cause(const Range& range, const Eigen::VectorXcd& poles) {
  Complex least = 0;
  double ratio = light_damping;
  for (const Complex pole : poles) {
    const double hz = pole.imag() / two_pi;
    if (hz < range.from_hz || hz > range.to_hz) continue;
    if (-pole.real() / std::abs(pole) >= ratio) continue;
    least = pole;
    ratio = -pole.real() / std::abs(pole);
  }
  if (least == Complex(0)) return "the design, which no rate mends";
  return formatted(
      "the law leaves a motion at %.4g Hz to a damping ratio of %.2g, which no rate mends",
      least.imag() / two_pi, ratio);
}

/// Where the controlled frame moves more than the passive one: ranges that matter, and those where
/// little is left of the floor anyway.
class Amplified {
 public:
  void add(double hz, double controlled, double factor, bool designed) {
    const bool more = factor > noted_ratio, matters = controlled > little;
    of_design.add(hz, more && designed ? factor : 0);
    of_sampling.add(hz, more && matters && !designed ? factor : 0);
    const bool little_of_sampling = more && !matters && !designed;
    of_little.add(hz, little_of_sampling ? factor : 0);
    if (little_of_sampling) most_left = std::max(most_left, controlled);
  }

  Ranges of_design, of_sampling, of_little;
  double most_left = 0;
};

}  // namespace

Remarks amplification(const LoopSettings& settings, double target_hz) {
  if (!(target_hz < 0.5 / settings.sampling.sample_time)) return {};
  const LoopPlant& plant = settings.plant;
  const SampledPlant sampled = sample_and_hold(plant, settings.sampling);
  const ForceFeedback feedback = continuous_law(settings);
  const Index n_w = plant.B_w.cols();
  LargestGain passive(open_loop(sampled)), controlled(close_loop(sampled, whole_law_of(settings)));
  LargestGain law(continuous_loop(plant, feedback), n_w),
      without({plant.A, plant.B_w, plant.C_y, plant.D_yw}, n_w);
  const Eigen::VectorXd grid =
      logarithmic_frequencies(target_hz, 0.5 / settings.sampling.sample_time, 200);
  Amplified found;
  for (const double hz : with_resonances(grid, controlled.resonances())) {
    const double value = controlled(hz), factor = value / passive(hz);
    // Most of it, in dB. Of a law of one's own nobody knows what it would do without sampling.
    const bool designed =
        !settings.own && factor > noted_ratio && std::pow(law(hz) / without(hz), 2) > factor;
    found.add(hz, value, factor, designed);
  }
  std::string price = ": the price of sampling; a higher rate moves it up";
  if (!settings.sampling.instruments.ideal()) {
    price =
        ": the price of sampling and of the instruments; a higher rate moves up what is of "
        "sampling";
  }
  if (!settings.feed_forward.empty() || (settings.own && settings.own->feed_forward.D.size() > 0)) {
    price = ": the price of what the feed-forward wins below";
  } else if (settings.own) {
    price.clear();
  }
  Remarks out;
  if (!found.of_design.empty()) {
    out.warnings.push_back(found.of_design.text() + ", and most of that without sampling too: " +
                           cause(found.of_design.worst(), closed_loop_poles(plant, feedback)));
  }
  if (!found.of_sampling.empty()) out.warnings.push_back(found.of_sampling.text() + price);
  if (!found.of_little.empty()) {
    out.notes.push_back(found.of_little.text() + at_most_db(found.most_left) + price);
  }
  return out;
}

}  // namespace stillframe::tools
