#include "core/scene/signals.hpp"

#include <algorithm>
#include <set>

#include "core/scene/structure.hpp"

namespace stillframe {

namespace {

enum class Side { input, output };

/// The quantity is the key: {name: a, acceleration: mount_1, along: y} or {name: s, stress: leg_1}.
SceneSignal read_signal(const YamlReader& value, Side side, const Scene& scene) {
  struct Key {
    const char* word;
    Quantity quantity;
    bool of_element, as_input, as_output;
  };
  static constexpr Key keys[] = {
      {"position", Quantity::position, false, true, true},
      {"velocity", Quantity::velocity, false, true, true},
      {"acceleration", Quantity::acceleration, false, true, true},
      {"force", Quantity::force, false, true, false},
      {"stress", Quantity::stress, true, true, true},
      {"deformation", Quantity::deformation, true, false, true},
  };
  if (side == Side::input) {
    value.allow_only({"name", "along", "position", "velocity", "acceleration", "force", "stress"});
  } else {
    value.allow_only(
        {"name", "along", "position", "velocity", "acceleration", "stress", "deformation"});
  }
  SceneSignal signal;
  signal.place = value.place();
  signal.name = value.require("name").text();
  int found = 0;
  for (const Key& key : keys) {
    const auto where = value.find(key.word);
    if (!where) continue;
    ++found;
    signal.quantity = key.quantity;
    if (key.of_element) {
      require_element(*where, where->text(), scene);
      signal.element = where->text();
    } else {
      require_node(*where, where->text(), scene);
      signal.node = where->text();
    }
  }
  if (found != 1) {
    value.fail(side == Side::input
                   ? "an input has one of position, velocity, acceleration, force, stress"
                   : "an output has one of position, velocity, acceleration, stress, deformation");
  }
  const auto along = value.find("along");
  if (!signal.node.empty() == !along) {
    value.fail(along ? "the signal of an element has no direction"
                     : "the key 'along' (a direction) is missing");
  }
  if (along) signal.direction = read_direction(*along);
  return signal;
}

void read_list(const YamlReader& root, const char* key, Side side, const Scene& scene,
               std::set<std::string>& names, std::vector<SceneSignal>& signals) {
  const auto list = root.find(key);
  if (!list) return;
  for (const YamlReader& value : list->items()) {
    signals.push_back(read_signal(value, side, scene));
    if (!names.insert(signals.back().name).second) {
      value.fail("the name '" + signals.back().name + "' is used twice");
    }
  }
}

std::string read_monitor_name(const YamlReader& value, const Scene& scene) {
  std::vector<std::string> names;
  for (const auto& signal : scene.outputs) names.push_back(signal.name);
  for (const auto& signal : scene.monitors) names.push_back(signal.name);
  const std::string name = value.text();
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    const std::string near = nearest_name(name, names);
    value.fail("there is no output or monitor named '" + name + "'" +
               (near.empty() ? "" : "; the nearest name is '" + near + "'"));
  }
  return name;
}

}  // namespace

void read_signals(const YamlReader& root, Scene& scene) {
  std::set<std::string> input_names, output_names;
  read_list(root, "inputs", Side::input, scene, input_names, scene.inputs);
  read_list(root, "outputs", Side::output, scene, output_names, scene.outputs);
  read_list(root, "monitors", Side::output, scene, output_names, scene.monitors);
  if (const auto list = root.find("compare")) {
    for (const auto& [name, value] : list->entries()) {
      value.allow_only({"floor", "frame"});
      scene.comparisons.push_back({name, value.place(),
                                   read_monitor_name(value.require("floor"), scene),
                                   read_monitor_name(value.require("frame"), scene)});
    }
  }
}

}  // namespace stillframe
