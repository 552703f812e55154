#include "core/scene/structure.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace stillframe {

namespace {

template <class Item>
void require_name(const YamlReader& value, const std::string& name, const std::vector<Item>& items,
                  const std::string& what) {
  std::vector<std::string> names;
  for (const Item& item : items) names.push_back(item.name);
  if (std::find(names.begin(), names.end(), name) != names.end()) return;
  const std::string near = nearest_name(name, names);
  value.fail("there is no " + what + " named '" + name + "'" +
             (near.empty() ? "" : "; the nearest name is '" + near + "'"));
}

std::string read_node_name(const YamlReader& value, const Scene& scene) {
  require_node(value, value.text(), scene);
  return value.text();
}

SceneNode read_node(const std::string& name, const YamlReader& value) {
  value.allow_only({"position"});
  return {name, value.place(), value.require("position").vector(3)};
}

/// Three principal moments about the global axes, or the whole matrix.
Eigen::Matrix3d read_inertia(const YamlReader& value) {
  Eigen::Matrix3d inertia;
  const auto items = value.items();
  if (!items.empty() && items.front().is_sequence()) {
    inertia = value.matrix(3, 3);
  } else {
    inertia = value.vector(3).asDiagonal();
  }
  if ((inertia - inertia.transpose()).cwiseAbs().maxCoeff() > 0) {
    value.fail("the inertia matrix is not symmetric");
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
  const Eigen::Vector3d moments = solver.eigenvalues();  // ascending
  if (moments(0) < 0) value.fail("the inertia matrix has a negative principal moment");
  // A body's largest principal moment never exceeds the sum of the others; 1e-12 is rounding.
  if (moments(2) > (moments(0) + moments(1)) * (1 + 1e-12)) {
    value.fail("no body has these principal moments: the largest exceeds the sum of the other two");
  }
  return inertia;
}

SceneMass read_mass(const YamlReader& value, const Scene& scene) {
  value.allow_only({"node", "mass", "inertia"});
  SceneMass mass;
  mass.place = value.place();
  mass.node = read_node_name(value.require("node"), scene);
  mass.mass = value.require("mass").non_negative();
  mass.inertia.setZero();
  if (const auto inertia = value.find("inertia")) {
    mass.inertia = read_inertia(*inertia);
    mass.has_inertia = true;
  }
  return mass;
}

void read_truss_properties(const YamlReader& value, SceneElement& element) {
  if (const auto rigid = value.find("rigid")) element.rigid = rigid->boolean();
  const auto stiffness = value.find("stiffness");
  if (element.rigid) {
    for (const char* key : {"stiffness", "damping", "preload"}) {
      if (const auto given = value.find(key)) given->fail("a rigid element has none");
    }
    return;
  }
  if (!stiffness) value.fail("a truss needs a stiffness, or rigid: true");
  element.stiffness = stiffness->non_negative();
  if (const auto damping = value.find("damping")) element.damping = damping->non_negative();
  if (const auto preload = value.find("preload")) element.preload = preload->number();
}

SceneElement read_element(const std::string& name, const YamlReader& value, const Scene& scene) {
  SceneElement element;
  element.name = name;
  element.place = value.place();
  const std::string type = value.require("type").one_of({"truss", "rigid_beam"});
  if (type == "truss") {
    value.allow_only({"type", "nodes", "stiffness", "damping", "preload", "rigid"});
    element.kind = SceneElement::Kind::truss;
    read_truss_properties(value, element);
  } else {
    value.allow_only({"type", "nodes"});
    element.kind = SceneElement::Kind::rigid_beam;
    element.rigid = true;
  }
  const auto ends = value.require("nodes").items();
  if (ends.size() != 2) value.require("nodes").fail("an element has two nodes, [p, q]");
  element.node_p = read_node_name(ends[0], scene);
  element.node_q = read_node_name(ends[1], scene);
  const auto position = [&](const std::string& node) {
    return std::find_if(scene.nodes.begin(), scene.nodes.end(),
                        [&](const SceneNode& n) { return n.name == node; })
        ->position;
  };
  if ((position(element.node_q) - position(element.node_p)).norm() == 0) {
    value.require("nodes").fail("the element has zero length: '" + element.node_p + "' and '" +
                                element.node_q + "' stand at the same position");
  }
  return element;
}

/// `key` holds the directions (and the word rotation where that is allowed); one constraint for
/// each node.
void read_constraints(const YamlReader& list, const char* key, bool rotation_allowed,
                      const Scene& scene, std::vector<SceneConstraint>& constraints) {
  for (const YamlReader& value : list.items()) {
    value.allow_only({"nodes", key});
    SceneConstraint constraint;
    constraint.place = value.place();
    for (const YamlReader& item : value.require(key).items()) {
      if (rotation_allowed && item.is_scalar() && item.text() == "rotation") {
        constraint.rotation = true;
      } else {
        constraint.directions.push_back(read_direction(item));
      }
    }
    for (const YamlReader& node : value.require("nodes").items()) {
      constraint.node = read_node_name(node, scene);
      constraints.push_back(constraint);
    }
  }
}

SceneDof read_dof(const YamlReader& value, const Scene& scene) {
  value.allow_only({"element", "node", "along", "euler_parameter"});
  SceneDof dof;
  dof.place = value.place();
  const auto element = value.find("element");
  const auto node = value.find("node");
  if (!element == !node) value.fail("a dof names either an element or a node");
  if (element) {
    require_element(*element, element->text(), scene);
    dof.element = element->text();
    return dof;
  }
  dof.node = read_node_name(*node, scene);
  const auto along = value.find("along");
  const auto parameter = value.find("euler_parameter");
  if (!along == !parameter) value.fail("a dof of a node needs either 'along' or 'euler_parameter'");
  if (along) {
    dof.direction = read_direction(*along);
  } else {
    dof.euler_parameter = std::stoi(parameter->one_of({"1", "2", "3"}));
  }
  return dof;
}

}  // namespace

void require_node(const YamlReader& value, const std::string& name, const Scene& scene) {
  require_name(value, name, scene.nodes, "node");
}

void require_element(const YamlReader& value, const std::string& name, const Scene& scene) {
  require_name(value, name, scene.elements, "element");
}

Eigen::Vector3d read_direction(const YamlReader& value) {
  if (value.is_scalar()) {
    const std::string axis = value.one_of({"x", "y", "z"});
    return Eigen::Vector3d::Unit(axis[0] - 'x');
  }
  const Eigen::Vector3d direction = value.vector(3);
  if (direction.norm() == 0) value.fail("a direction cannot be zero");
  return direction.normalized();
}

void read_structure(const YamlReader& root, Scene& scene) {
  for (const auto& [name, value] : root.require("nodes").entries()) {
    scene.nodes.push_back(read_node(name, value));
  }
  for (const YamlReader& value : root.require("masses").items()) {
    scene.masses.push_back(read_mass(value, scene));
  }
  for (const auto& [name, value] : root.require("elements").entries()) {
    scene.elements.push_back(read_element(name, value, scene));
  }
  if (const auto list = root.find("supports")) {
    read_constraints(*list, "fix", true, scene, scene.supports);
  }
  if (const auto list = root.find("prescribed")) {
    read_constraints(*list, "move", false, scene, scene.prescribed);
  }
  const YamlReader dofs = root.require("dofs");
  scene.dofs_place = dofs.place();
  for (const YamlReader& value : dofs.items()) scene.dofs.push_back(read_dof(value, scene));
  if (const auto list = root.find("loads")) {
    for (const YamlReader& value : list->items()) {
      value.allow_only({"node", "force"});
      scene.loads.push_back({read_node_name(value.require("node"), scene), value.place(),
                             value.require("force").vector(3)});
    }
  }
}

}  // namespace stillframe
