#include "core/mechanics/scene/signals.hpp"

#include <algorithm>
#include <set>
#include <string_view>
#include <vector>

#include "core/mechanics/scene/quantity.hpp"
#include "core/mechanics/scene/references.hpp"

namespace stillframe {

namespace {

enum class Side { input, output };

bool goes_to(Side side, const QuantityTraits& key) {
  return side == Side::input ? key.as_input : key.as_output;
}

void allow_signal_keys(const YamlReader& value, Side side) {
  std::vector<std::string_view> keys{"name", "along", "mode"};
  for (const QuantityTraits& key : known_quantities) {
    if (goes_to(side, key)) keys.emplace_back(key.word);
  }
  value.allow_only(keys);
}

/// The one quantity of a signal.
const QuantityTraits& find_signal_key(const YamlReader& value, Side side) {
  const QuantityTraits* found = nullptr;
  int n_found = 0;
  std::string words;
  for (const QuantityTraits& key : known_quantities) {
    if (!goes_to(side, key)) continue;
    words += (words.empty() ? "" : ", ") + std::string(key.word);
    if (!value.find(key.word)) continue;
    found = &key;
    ++n_found;
  }
  if (n_found != 1) {
    value.fail((side == Side::input ? "an input has one of " : "an output has one of ") + words);
  }
  return *found;
}

/// All rotations of a planar scene are about z, those of a spatial one about a given direction.
Eigen::Vector3d read_along(const YamlReader& value, const QuantityTraits& key, const Scene& scene) {
  const auto along = value.find("along");
  if (scene.planar && key.of == SignalOf::rotation) {
    if (along) along->fail("a planar scene turns about z and needs none");
    return Eigen::Vector3d::UnitZ();
  }
  if (!along) value.fail("the key 'along' (a direction) is missing");
  return read_direction(*along, scene);
}

/// The quantity is the key: {name: a, acceleration: mount_1, along: y} or {name: s, stress: leg_1}.
SceneSignal read_signal(const YamlReader& value, Side side, const Scene& scene) {
  allow_signal_keys(value, side);
  SceneSignal signal;
  signal.place = value.place();
  signal.name = value.require("name").text();
  const QuantityTraits& key = find_signal_key(value, side);
  signal.quantity = key.quantity;
  const YamlReader where = value.require(key.word);
  if (key.of == SignalOf::deformation) {
    const SceneElement& element = read_element_name(where, scene);
    signal.element = element.name;
    signal.mode = read_mode(value, element, 1);
    if (value.find("along")) value.fail("the signal of an element has no direction");
    return signal;
  }
  signal.node = read_node_name(where, scene).name;
  if (const auto mode = value.find("mode")) mode->fail("the signal of a node has none");
  if (!scene.planar && side == Side::input && key.of == SignalOf::rotation &&
      key.quantity != Quantity::torque) {
    where.fail(
        "only in a planar scene can the rotation of a node be an input; prescribe a deformation of "
        "a hinge instead");
  }
  signal.direction = read_along(value, key, scene);
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

/// Whether the motion that an output or monitor measures is one that the scene prescribes.
bool is_prescribed(const std::string& name, const Scene& scene) {
  const auto named = [&](const SceneSignal& signal) { return signal.name == name; };
  auto found = std::find_if(scene.outputs.begin(), scene.outputs.end(), named);
  if (found == scene.outputs.end()) {
    found = std::find_if(scene.monitors.begin(), scene.monitors.end(), named);
  }
  // What is left of its direction beside the prescribed ones.
  Eigen::Vector3d rest = found->direction;
  std::vector<Eigen::Vector3d> basis;
  for (const SceneConstraint& motion : scene.prescribed) {
    if (motion.node != found->node) continue;
    for (Eigen::Vector3d axis : motion.directions) {
      for (const Eigen::Vector3d& other : basis) axis -= other.dot(axis) * other;
      if (axis.norm() < 1e-9) continue;
      basis.push_back(axis.normalized());
      rest -= basis.back().dot(rest) * basis.back();
    }
  }
  return !basis.empty() && rest.norm() < 1e-9;
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
      const YamlReader frame = value.require("frame");
      if (value.require("floor").text() == frame.text()) {
        frame.fail("'" + frame.text() + "' cannot be the floor and the frame of a comparison");
      }
      const std::string above = read_monitor_name(frame, scene);
      if (is_prescribed(above, scene)) {
        frame.fail("'" + above +
                   "' is the motion of a node that is prescribed: it is a floor, and what stands "
                   "on it is the frame");
      }
      scene.comparisons.push_back(
          {name, value.place(), read_monitor_name(value.require("floor"), scene), above});
    }
  }
}

}  // namespace stillframe
