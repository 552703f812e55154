#include "core/mechanics/scene/controller_block.hpp"

#include <algorithm>

#include "core/mechanics/scene/references.hpp"
#include "core/yaml/loop_numbers.hpp"
#include "core/yaml/ranges.hpp"

namespace stillframe {

namespace {

/// A leg carries the actuator and the force sensor along it, so its first deformation (elongation)
/// has to be elastic, and it has to be there once.
std::vector<std::string> read_legs(const YamlReader& list, const Scene& scene) {
  std::vector<std::string> legs;
  for (const YamlReader& item : list.items()) {
    const SceneElement& element = read_element_name(item, scene);
    if (element.zero.front()) {
      item.fail("'" + element.name + "' is rigid" + (element.rigid() ? "" : " in deformation 1") +
                ": it can be no actuator");
    }
    if (std::find(legs.begin(), legs.end(), element.name) != legs.end()) item.fail("named twice");
    legs.push_back(element.name);
  }
  if (legs.empty()) list.fail("at least one leg is needed");
  return legs;
}

/// More than this is two poles decades apart, and no target.
constexpr double highest_damping_ratio = 100;

/// One positive number, or one for each virtual mode. How many of those there are the model tells:
/// legs or degrees of freedom, whichever are fewer.
std::vector<double> read_targets(const YamlReader& value, size_t n_legs, double highest) {
  if (!value.is_sequence()) return {positive_up_to(value, highest)};
  std::vector<double> targets;
  for (const YamlReader& item : value.items()) targets.push_back(positive_up_to(item, highest));
  if (targets.empty() || targets.size() > n_legs) {
    value.fail("found " + std::to_string(targets.size()) +
               " numbers, allowed are one, or one for each virtual mode, at most " +
               std::to_string(n_legs));
  }
  return targets;
}

/// A relative deviation, below one so that nothing can vanish.
double read_part(const YamlReader& block, const std::string& key) {
  const auto value = block.find(key);
  if (!value) return 0;
  const double part = value->non_negative();
  if (part >= 1) value->fail("found " + value->text() + ", allowed is 0 to below 1");
  return part;
}

// What is left of the axis behind to_hz has to have room for the transition and for what is paid.
constexpr double highest_part_of_rate = 0.25, part_of_rate = 0.05, part_of_target = 0.1;
constexpr double most_db = 40;

/// Of a law's file: one of as many states as a loop may have takes a tenth of it.
constexpr std::size_t most_law_bytes = std::size_t{16} << 20;

SceneFeedForward read_feed_forward(const YamlReader& block, const SceneController& controller) {
  block.allow_only({"to_hz", "corner_hz", "target_hz", "damping_ratio", "at_most_db",
                    "actuator_error", "noise_over_floor", "taps"});
  const double rate = controller.sample_rate_hz;
  SceneFeedForward found;
  found.to_hz = part_of_rate * rate;
  if (const auto value = block.find("target_hz")) {
    found.target_hz = positive_up_to(*value, highest_hz);
  }
  if (const auto value = block.find("damping_ratio")) {
    found.damping_ratio = positive_up_to(*value, highest_damping_ratio);
  }
  found.corner_hz = part_of_target * found.target_hz.value_or(controller.lowest_target_hz());
  if (const auto value = block.find("to_hz")) {
    found.to_hz = positive_up_to(*value, highest_part_of_rate * rate);
  }
  if (const auto value = block.find("corner_hz")) {
    found.corner_hz = positive_up_to(*value, found.to_hz);
  } else if (found.corner_hz > found.to_hz) {
    block.fail(
        "corner_hz: a tenth of the target is above to_hz; the target is too high for "
        "a feed-forward at this rate");
  }
  if (const auto value = block.find("at_most_db")) {
    found.at_most_db = number_within(*value, -2 * most_db, most_db);
  }
  if (const auto value = block.find("actuator_error")) {
    found.actuator_error = number_within(*value, 0, 0.5);
  }
  if (const auto value = block.find("noise_over_floor")) {
    found.noise_over_floor = positive_up_to(*value, 1);
  }
  if (const auto value = block.find("taps")) {
    found.taps = static_cast<int>(integer_within(*value, 2, most_taps));
  }
  return found;
}

}  // namespace

SceneController read_controller(const YamlReader& block, const Scene& scene) {
  block.allow_only({"legs", "target_hz", "damping_ratio", "order", "reduction", "realisation",
                    "sample_rate_hz", "delay_samples", "leak_hz", "high_pass_hz", "lead_samples",
                    "roll_off_hz", "force_limit_n", "feed_forward", "law"});
  SceneController controller;
  controller.place = block.place();
  controller.legs = read_legs(block.require("legs"), scene);
  controller.target_hz =
      read_targets(block.require("target_hz"), controller.legs.size(), highest_hz);
  controller.damping_ratio =
      read_targets(block.require("damping_ratio"), controller.legs.size(), highest_damping_ratio);
  if (const auto value = block.find("order")) {
    controller.order =
        value->one_of({"exact", "deck"}) == "exact" ? GainOrder::exact : GainOrder::deck;
  }
  if (const auto value = block.find("reduction")) {
    controller.reduction = value->one_of({"modes", "static_shapes"}) == "modes"
                               ? Reduction::modes
                               : Reduction::static_shapes;
  }
  if (const auto value = block.find("realisation")) {
    const std::string word = value->one_of({"implicit_feedthrough", "naive_pi"});
    controller.realisation =
        word == "naive_pi" ? Realisation::naive_pi : Realisation::implicit_feedthrough;
  }
  controller.sample_rate_hz =
      number_within(block.require("sample_rate_hz"), lowest_rate_hz, highest_rate_hz);
  controller.delay_samples =
      number_within(block.require("delay_samples"), 0, longest_delay_samples);
  if (const auto value = block.find("law")) {
    const auto [path, bytes] = value->file_bytes(most_law_bytes);
    controller.law = SceneLaw{.file = path.string(), .bytes = bytes};
  }
  // A law of one's own need have none.
  if (!controller.law || block.find("leak_hz")) {
    controller.leak_hz = number_within(block.require("leak_hz"), 0, highest_hz);
  }
  if (const auto value = block.find("high_pass_hz")) {
    controller.high_pass_hz = number_within(*value, 0, highest_hz);
  }
  if (const auto value = block.find("lead_samples")) {
    controller.lead_samples = number_within(*value, 0, longest_lead_samples);
  }
  if (const auto value = block.find("roll_off_hz")) {
    controller.roll_off_hz = positive_up_to(*value, highest_hz);
    if (*controller.roll_off_hz >= controller.sample_rate_hz / 2) {
      value->fail("found " + value->text() + ", allowed is below half the sample rate");
    }
  }
  if (const auto value = block.find("force_limit_n")) {
    controller.force_limit_n = positive_up_to(*value, largest_force_n);
  }
  if (const auto value = block.find("feed_forward")) {
    controller.feed_forward = read_feed_forward(*value, controller);
  }
  return controller;
}

SceneUncertainty read_uncertainty(const YamlReader& block) {
  block.allow_only({"stiffness", "damping", "mass", "inertia", "centre_of_mass_m",
                    "leg_direction_rad", "actuator_gain", "sensor_gain", "delay_samples"});
  SceneUncertainty uncertainty;
  uncertainty.place = block.place();
  uncertainty.stiffness = read_part(block, "stiffness");
  uncertainty.damping = read_part(block, "damping");
  uncertainty.mass = read_part(block, "mass");
  uncertainty.inertia = read_part(block, "inertia");
  uncertainty.actuator_gain = read_part(block, "actuator_gain");
  uncertainty.sensor_gain = read_part(block, "sensor_gain");
  if (const auto value = block.find("centre_of_mass_m")) {
    uncertainty.centre_of_mass_m = value->non_negative();
  }
  if (const auto value = block.find("leg_direction_rad")) {
    uncertainty.leg_direction_rad = number_within(*value, 0, 1);
  }
  if (const auto value = block.find("delay_samples")) {
    uncertainty.delay_samples = number_within(*value, 0, longest_delay_samples);
  }
  return uncertainty;
}

}  // namespace stillframe
