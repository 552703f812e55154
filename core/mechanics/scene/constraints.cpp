#include "core/mechanics/scene/constraints.hpp"

#include "core/mechanics/scene/references.hpp"

namespace stillframe {

namespace {

/// The directions of `list`, and the word rotation; where that is not allowed `refusal` says why.
void read_directions(const YamlReader& list, const char* refusal, const Scene& scene,
                     SceneConstraint& constraint) {
  for (const YamlReader& item : list.items()) {
    if (item.is_scalar() && item.text() == "rotation") {
      if (refusal) item.fail(refusal);
      constraint.rotation = true;
    } else {
      constraint.directions.push_back(read_direction(item, scene));
    }
  }
}

void add_for_each_node(const YamlReader& nodes, SceneConstraint constraint, const Scene& scene,
                       std::vector<SceneConstraint>& constraints) {
  for (const YamlReader& node : nodes.items()) {
    constraint.node = read_node_name(node, scene).name;
    constraints.push_back(constraint);
  }
}

void read_motion(const YamlReader& value, SceneConstraint& constraint) {
  if (const auto given = value.find("value")) constraint.value = read_displacement(*given);
  if (const auto given = value.find("rate")) constraint.rate = given->number();
  if (const auto given = value.find("acceleration")) constraint.acceleration = given->number();
}

/// {element: E, mode: k}: a deformation that is moved, so it can be no rigid one.
void read_prescribed_deformation(const YamlReader& value, const Scene& scene,
                                 SceneConstraint& constraint) {
  if (const auto given = value.find("move")) given->fail("belongs to 'nodes', not to 'element'");
  const SceneElement& element = read_element_name(value.require("element"), scene);
  constraint.element = element.name;
  constraint.mode = read_mode(value, element, 0);
  if (element.zero[static_cast<size_t>(constraint.mode) - 1]) {
    value.fail("deformation " + std::to_string(constraint.mode) + " of '" + element.name +
               "' is rigid and cannot be prescribed");
  }
}

SceneLoad read_load(const YamlReader& value, const Scene& scene) {
  value.allow_only({"node", "force", "torque", "follows"});
  SceneLoad load;
  load.place = value.place();
  load.node = read_node_name(value.require("node"), scene).name;
  const auto force = value.find("force"), torque = value.find("torque");
  if (!force && !torque) value.fail("a load needs a 'force' or a 'torque' or both");
  if (force) load.force = read_vector(*force, scene);
  if (torque) {
    load.torque =
        scene.planar ? Eigen::Vector3d(0, 0, torque->number()) : read_vector(*torque, scene);
  }
  if (const auto given = value.find("follows")) load.follows = given->boolean();
  return load;
}

}  // namespace

void read_supports(const YamlReader& list, Scene& scene) {
  for (const YamlReader& value : list.items()) {
    value.allow_only({"nodes", "fix"});
    SceneConstraint constraint;
    constraint.place = value.place();
    read_directions(value.require("fix"), nullptr, scene, constraint);
    add_for_each_node(value.require("nodes"), constraint, scene, scene.supports);
  }
}

void read_prescribed(const YamlReader& list, Scene& scene) {
  const char* const refusal =
      scene.planar ? nullptr
                   : "only a planar scene prescribes the rotation of a node; prescribe a "
                     "deformation of a hinge instead";
  for (const YamlReader& value : list.items()) {
    value.allow_only({"nodes", "move", "element", "mode", "value", "rate", "acceleration"});
    SceneConstraint constraint;
    constraint.place = value.place();
    read_motion(value, constraint);
    const auto nodes = value.find("nodes");
    if (!nodes == !value.find("element")) {
      value.fail("a prescribed motion names either 'nodes' or an 'element'");
    }
    if (!nodes) {
      read_prescribed_deformation(value, scene, constraint);
      scene.prescribed.push_back(constraint);
      continue;
    }
    if (const auto given = value.find("mode")) given->fail("belongs to 'element', not to 'nodes'");
    read_directions(value.require("move"), refusal, scene, constraint);
    add_for_each_node(*nodes, constraint, scene, scene.prescribed);
  }
}

void read_loads(const YamlReader& list, Scene& scene) {
  for (const YamlReader& value : list.items()) scene.loads.push_back(read_load(value, scene));
}

}  // namespace stillframe
