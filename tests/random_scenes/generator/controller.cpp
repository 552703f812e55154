#include <algorithm>
#include <cmath>

#include "tests/random_scenes/generator/draft.hpp"

namespace stillframe::random_scenes {

void add_controller(Draft& draft) {
  if (draft.monitors.empty()) return;  // no signals of a loop
  Draws& draws = draft.draws;
  // From too slow for the stiffest legs to faster than any needs.
  const double rate = std::clamp(draft.frequency_hz * draws.scale(8, 400), 100.0, 20000.0);
  draft.rate_hz = 4 * std::round(rate / 4);
  std::string legs;
  for (const Strut& leg : draft.legs) legs += (legs.empty() ? "" : ", ") + leg.name;
  auto& out = draft.blocks;
  out.push_back("controller:");
  const auto key = [&out](const std::string& name, const std::string& value) {
    out.push_back("  " + name + ": " + value);
  };
  key("legs", "[" + legs + "]");
  key("target_hz", Draft::number(draft.frequency_hz * draws.scale(0.1, 0.8)));
  key("damping_ratio", Draft::number(draws.between(0.3, 1.2)));
  if (draws.chance(0.1)) key("order", "deck");
  if (draws.chance(0.2)) key("reduction", "modes");
  if (draws.chance(0.03)) key("realisation", "naive_pi");
  key("sample_rate_hz", Draft::number(draft.rate_hz));
  double delay = draws.between(0, 2.5);
  if (draws.chance(0.6)) delay = std::floor(delay);
  key("delay_samples", Draft::number(delay));
  // As fits the delay, somewhere about it, or none.
  const int lead = draws.below(3);
  if (lead == 0) key("lead_samples", Draft::number(delay + 0.5));
  if (lead == 1) key("lead_samples", Draft::number((delay + 0.5) * draws.between(0, 2)));
  key("leak_hz",
      draws.chance(0.05) ? "0" : Draft::number(draft.frequency_hz * draws.scale(3e-3, 0.3)));
  if (draws.chance(0.15))
    key("high_pass_hz", Draft::number(draft.frequency_hz * draws.scale(1e-3, 0.03)));
  if (draws.chance(0.3))
    key("roll_off_hz",
        Draft::number(std::min(draft.frequency_hz * draws.scale(3, 60), 0.45 * draft.rate_hz)));
  if (draws.chance(0.2)) {
    const double force = draft.legs[0].stiffness * draft.frame.size;
    key("force_limit_n", Draft::number(force * draws.scale(1e-8, 1)));
  }
}

void add_instruments(Draft& draft) {
  if (draft.rate_hz == 0 || !draft.draws.chance(0.4)) return;
  Draws& draws = draft.draws;
  const double force = draft.legs[0].stiffness * draft.frame.size;
  auto& out = draft.blocks;
  out.push_back("instruments:");
  const auto maybe = [&](double probability, const std::string& name, const std::string& value) {
    if (draws.chance(probability)) out.push_back("  " + name + ": " + value);
  };
  const auto hz = [&](double low, double high) {
    return Draft::number(std::min(draft.frequency_hz * draws.scale(low, high), draft.rate_hz));
  };
  out.push_back("  actuator_gain: " + Draft::number(draws.between(0.7, 1.3)));
  maybe(0.4, "actuator_lag_hz", hz(5, 60));
  maybe(0.4, "sensor_filter_hz", hz(5, 60));
  maybe(0.3, "applied_force", "commanded");
  maybe(0.2, "report_age_samples", std::to_string(draws.whole(1, 2)));
  maybe(0.1, "force_rate_limit_n_per_s",
        Draft::number(force * draft.frequency_hz * draws.scale(1e-4, 1)));
  maybe(0.1, "hysteresis",
        "{width: " + Draft::number(draws.between(0.02, 0.2)) +
            ", swing_n: " + Draft::number(force * draws.scale(1e-4, 1e-2)) + "}");
  maybe(0.3, "force_sensors",
        "{noise_n_per_sqrt_hz: " + Draft::number(force * draws.scale(1e-12, 1e-8)) +
            ", offset_n: " + Draft::number(force * draws.scale(1e-9, 1e-5)) + "}");
  maybe(0.2, "floor_sensors", "{noise: " + Draft::number(draws.scale(1e-9, 1e-6)) + "}");
}

}  // namespace stillframe::random_scenes
