#include "core/mechanics/scene/corrections.hpp"

#include <algorithm>
#include <functional>

#include "core/mechanics/scene/alter.hpp"
#include "core/mechanics/scene/references.hpp"
#include "core/yaml/loop_numbers.hpp"
#include "core/yaml/ranges.hpp"

namespace stillframe {

namespace {

using Each = std::function<void(const std::string& name, const YamlReader& value)>;

template <class Named>
std::vector<std::string> names_of(const std::vector<Named>& list) {
  std::vector<std::string> names;
  for (const Named& each : list) names.push_back(each.name);
  return names;
}

/// Each entry of a map from names that there are.
void for_each(const YamlReader& block, const std::string& key, const char* what,
              const std::vector<std::string>& names, const Each& each) {
  const auto map = block.find(key);
  if (!map) return;
  for (const auto& [name, value] : map->entries()) {
    if (std::ranges::find(names, name) == names.end()) {
      const std::string near = nearest_name(name, names);
      value.fail("there is no " + std::string(what) + " named '" + name + "'" +
                 (near.empty() ? "" : "; the nearest name is '" + near + "'"));
    }
    each(name, value);
  }
}

/// 1 and a relative change, above 0.
double factor_of(const YamlReader& value) {
  const double change = value.number();
  if (!(change > -1)) value.fail("found " + value.text() + ", allowed is above -1");
  return 1 + change;
}

void correct_masses(const YamlReader& block, Scene& scene) {
  std::vector<std::string> nodes;
  for (const SceneMass& mass : scene.masses) nodes.push_back(mass.node);
  for_each(block, "mass", "node with a mass", nodes, [&](const auto& name, const auto& value) {
    for (SceneMass& mass : scene.masses) {
      if (mass.node == name) mass.mass *= factor_of(value);
    }
  });
  nodes.clear();
  for (const SceneMass& mass : scene.masses) {
    if (mass.has_inertia) nodes.push_back(mass.node);
  }
  for_each(block, "inertia", "node with an inertia", nodes,
           [&](const auto& name, const auto& value) {
             for (SceneMass& mass : scene.masses) {
               if (mass.node == name) mass.inertia *= factor_of(value);
             }
           });
}

void correct_directions(const YamlReader& block, const Scene& as_written, Scene& scene) {
  const auto elements = names_of(as_written.elements);
  for_each(block, "leg_direction_rad", "element", elements,
           [&](const std::string& name, const YamlReader& value) {
             const SceneLeg leg = leg_of(as_written, name);
             if (leg.span.isZero(0)) value.fail("'" + name + "' has no length, so no direction");
             const auto directions = across(leg.span, scene.planar);
             const Eigen::VectorXd angles =
                 value.vector(static_cast<Eigen::Index>(directions.size()), 1);
             Eigen::Vector3d angle = Eigen::Vector3d::Zero();
             for (std::size_t i = 0; i < directions.size(); ++i) {
               angle += angles(static_cast<Eigen::Index>(i)) * directions[i];
             }
             turn_leg(scene, leg, angle);
           });
}

}  // namespace

void correct(const YamlReader& block, Scene& scene) {
  block.allow_only({"stiffness", "damping", "mass", "inertia", "centre_of_mass_m",
                    "leg_direction_rad", "delay_samples"});
  const Scene as_written = scene;
  const auto elements = names_of(scene.elements);
  for_each(block, "stiffness", "element", elements, [&](const auto& name, const auto& value) {
    SceneElement& element = scene.elements[element_index(scene, name)];
    if (!is_stiff(element)) value.fail("'" + name + "' has no stiffness that could be corrected");
    scale_stiffness(element, factor_of(value));
  });
  for_each(block, "damping", "element", elements, [&](const auto& name, const auto& value) {
    SceneElement& element = scene.elements[element_index(scene, name)];
    if (!is_damped(element)) value.fail("'" + name + "' has no damping that could be corrected");
    scale_damping(element, factor_of(value));
  });
  correct_masses(block, scene);
  for_each(block, "centre_of_mass_m", "node", names_of(scene.nodes),
           [&](const auto& name, const auto& value) {
             move_node(scene, node_index(scene, name), read_vector(value, scene));
           });
  correct_directions(block, as_written, scene);
  if (const auto value = block.find("delay_samples")) {
    const double change = number_within(*value, -longest_delay_samples, longest_delay_samples);
    if (!scene.controller) return;
    double& delay = scene.controller->delay_samples;
    delay = std::clamp(delay + change, 0.0, double{longest_delay_samples});
  }
}

}  // namespace stillframe
