#include "core/scene/controller_block.hpp"

#include <algorithm>

#include "core/scene/references.hpp"

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

}  // namespace

SceneController read_controller(const YamlReader& block, const Scene& scene) {
  block.allow_only({"legs", "target_hz", "damping_ratio", "order", "realisation", "sample_rate_hz",
                    "delay_samples", "leak_hz", "lead_samples", "roll_off_hz", "force_limit_n"});
  SceneController controller;
  controller.place = block.place();
  controller.legs = read_legs(block.require("legs"), scene);
  controller.target_hz = block.require("target_hz").positive();
  controller.damping_ratio = block.require("damping_ratio").positive();
  if (const auto value = block.find("order")) {
    controller.order =
        value->one_of({"exact", "deck"}) == "exact" ? GainOrder::exact : GainOrder::deck;
  }
  if (const auto value = block.find("realisation")) {
    const std::string word = value->one_of({"implicit_feedthrough", "naive_pi"});
    controller.realisation =
        word == "naive_pi" ? Realisation::naive_pi : Realisation::implicit_feedthrough;
  }
  controller.sample_rate_hz = block.require("sample_rate_hz").positive();
  const YamlReader delay = block.require("delay_samples");
  controller.delay_samples = std::stoi(delay.one_of({"0", "1"}));
  controller.leak_hz = block.require("leak_hz").non_negative();
  if (const auto value = block.find("lead_samples")) {
    controller.lead_samples = value->non_negative();
  }
  if (const auto value = block.find("roll_off_hz")) {
    controller.roll_off_hz = value->positive();
    if (*controller.roll_off_hz >= controller.sample_rate_hz / 2) {
      value->fail("found " + value->text() + ", allowed is below half the sample rate");
    }
  }
  if (const auto value = block.find("force_limit_n")) controller.force_limit_n = value->positive();
  return controller;
}

}  // namespace stillframe
