#include "tools/design_remedies.hpp"

#include <cmath>
#include <vector>

#include "core/control/design/price_of_sampling.hpp"
#include "core/errors/formatted.hpp"
#include "core/numerics/infinity.hpp"
#include "tools/design_trade.hpp"

namespace stillframe::tools {

namespace {

struct Trial {
  std::string what;  ///< the settings that differ, as a scene has them
  LoopSettings settings;
};

void add_to(std::string& text, const std::string& setting) {
  text += (text.empty() ? "" : ", ") + setting;
}

/// Other leaks, and other targets with as much more of a leak.
std::vector<Trial> slow_trials(const judge::LoopDesign& design) {
  const LoopSettings& own = design.settings;
  const SceneController& block = *design.scene.controller;
  const auto leak = [&](Trial& trial, double times) {
    if (own.feedback.leak == 0) return;
    trial.settings.feedback.leak *= times;
    add_to(trial.what, formatted("leak_hz: %.3g", times * block.leak_hz));
  };
  std::vector<Trial> trials{{"", own}};
  for (const double times : {1.5, 2.0, 4.0}) {
    if (own.feedback.leak == 0) continue;
    trials.push_back({"", own});
    leak(trials.back(), times);
  }
  for (const double times : {1.5, 2.0, 3.0}) {
    if (block.law) break;  // its gains are numbers, of no target
    Trial trial{block.target_hz.size() == 1
                    ? formatted("target_hz: %g", times * block.target_hz.front())
                    : formatted("%g times target_hz", times),
                own};
    const ForceFeedback gains = retargeted(design, times).gains;
    trial.settings.feedback.K_P = gains.K_P;
    trial.settings.feedback.K_I = gains.K_I;
    leak(trial, times);
    trials.push_back(trial);
  }
  return trials;
}

/// Each of these with the scene's roll-off and lead, and with others; what changes least first.
std::vector<Trial> trials_of(const judge::LoopDesign& design) {
  const double target = design.scene.controller->lowest_target_hz();
  const double rate = 1 / design.settings.sampling.sample_time;
  std::vector<Trial> trials;
  for (const Trial& slow : slow_trials(design)) {
    if (!slow.what.empty()) trials.push_back(slow);
    for (const double times : tried_roll_offs) {
      if (times == 0 || times * target > 0.4 * rate) continue;
      Trial trial{slow.what, tuned(slow.settings, target, times)};
      add_to(trial.what, formatted("roll_off_hz: %g", times * target));
      add_to(trial.what, formatted("lead_samples: %.3g", trial.settings.law.lead_samples));
      trials.push_back(trial);
    }
    for (const double part : {0.5, 0.0}) {
      if (slow.settings.law.lead_samples == 0) continue;
      Trial trial = slow;
      trial.settings.law.lead_samples *= part;
      add_to(trial.what, formatted("lead_samples: %.3g", trial.settings.law.lead_samples));
      trials.push_back(trial);
    }
  }
  return trials;
}

}  // namespace

std::string what_widens(const judge::LoopDesign& design, double disk) {
  const double noted = 1.1 * disk;
  std::string best;
  double widest = noted;
  for (const Trial& trial : trials_of(design)) {
    if (!(spectral_radius(trial.settings) < largest_stable_radius)) continue;
    const double found = all_leg_disk_margin(trial.settings, noted).first;
    if (!(found > widest)) continue;
    best = trial.what + formatted(" makes it %.2f", found);
    widest = found;
    if (found >= least_disk_margin) break;
  }
  if (best.empty()) {
    return "no roll-off with its lead, less lead, more leak, higher target or two of these that "
           "were tried widens it";
  }
  return "of what was tried, " + best;
}

std::string why_none_recommended(const judge::LoopDesign& design) {
  constexpr double highest = 1e5;
  const double target = design.scene.controller->lowest_target_hz();
  double price = infinity, disk = 0, disk_hz = 0;
  bool stable = false, meets = false;
  for (const double times : tried_roll_offs) {
    const LoopSettings settings = tuned(at_rate(design.settings, highest), target, times);
    if (!(spectral_radius(settings) < largest_stable_radius)) continue;
    stable = true;
    const double costs = price_of_sampling(design.loop, target, settings);
    price = std::fmin(price, costs);
    if (!(costs <= most_price_db)) continue;
    const auto [found, hz] = all_leg_disk_margin(settings);
    if (found > disk) disk = found, disk_hz = hz;
    meets = meets || found >= least_disk_margin;
  }
  std::string why;
  if (!stable) {
    why = "at that rate the loop is not stable, with any roll-off that was tried";
  } else if (!(price <= most_price_db)) {
    const bool ideal = design.settings.sampling.instruments.ideal();
    why = formatted("at that rate %s %.1f dB up to four targets, and %g are allowed",
                    ideal ? "sampling costs" : "the instruments, and sampling a little, cost",
                    price, most_price_db);
  } else if (!meets) {
    why = formatted(
        "at that rate, with any roll-off that was tried, the disk margin is %.2f (at %.3g "
        "Hz), and %g is asked for",
        disk, disk_hz, least_disk_margin);
  } else {
    why = "what does at that rate does not at lower ones, or not without a warning";
  }
  if (design.settings.sampling.delay_samples == 0) return why;
  LoopSettings prompt = design.settings;
  prompt.sampling.delay_samples = 0;
  const auto found = recommend(design, prompt);
  return why + (found ? formatted("; without delay %g Hz could be", found->rate_hz)
                      : "; nor without delay");
}

}  // namespace stillframe::tools
