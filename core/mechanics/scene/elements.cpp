#include "core/mechanics/scene/elements.hpp"

#include <cmath>

#include "core/mechanics/scene/beam_keys.hpp"
#include "core/mechanics/scene/deformations.hpp"
#include "core/mechanics/scene/divide.hpp"
#include "core/mechanics/scene/references.hpp"
#include "core/mechanics/scene/superelement_keys.hpp"

namespace stillframe {

namespace {

using Kind = SceneElement::Kind;

Kind read_kind(const YamlReader& value) {
  const std::string type = value.one_of({"truss", "beam", "rigid_beam", "hinge", "superelement"});
  if (type == "truss") return Kind::truss;
  if (type == "beam") return Kind::beam;
  if (type == "superelement") return Kind::superelement;
  return type == "hinge" ? Kind::hinge : Kind::rigid_beam;
}

Eigen::Index number_of_deformations(Kind kind, bool planar) {
  switch (kind) {
    case Kind::truss:
      return 1;
    case Kind::hinge:
      return planar ? 1 : 3;
    case Kind::beam:
    case Kind::rigid_beam:
    case Kind::superelement:
      break;
  }
  return planar ? 3 : 6;
}

struct Ends {
  Eigen::Vector3d p, q;
};

/// A hinge has its nodes at one point, any other element has a length.
Ends read_ends(const YamlReader& value, const Scene& scene, SceneElement& element) {
  const YamlReader nodes = value.require("nodes");
  const auto names = nodes.items();
  if (names.size() != 2) nodes.fail("an element has two nodes, [p, q]");
  const SceneNode& p = read_node_name(names[0], scene);
  const SceneNode& q = read_node_name(names[1], scene);
  element.node_p = p.name;
  element.node_q = q.name;
  const double length = (q.position - p.position).norm();
  const std::string both = "'" + p.name + "' and '" + q.name + "'";
  if (element.kind != Kind::hinge && length == 0) {
    nodes.fail("the element has zero length: " + both + " stand at the same position");
  }
  if (element.kind == Kind::hinge && p.name == q.name) {
    nodes.fail("a hinge joins two nodes that turn against each other, found '" + p.name +
               "' twice");
  }
  if (element.kind == Kind::hinge && length > 0) {
    nodes.fail("the two nodes of a hinge stand at the same position; " + both + " are " +
               shown(length) + " m apart");
  }
  return {p.position, q.position};
}

void read_truss(const YamlReader& value, SceneElement& element) {
  value.allow_only({"type", "nodes", "stiffness", "damping", "preload", "rigid"});
  if (const auto given = value.find("rigid")) element.zero[0] = given->boolean();
  const auto stiffness = value.find("stiffness");
  if (element.rigid()) {
    for (const char* key : {"stiffness", "damping", "preload"}) {
      if (const auto given = value.find(key)) given->fail("a rigid element has none");
    }
    return;
  }
  if (!stiffness) value.fail("a truss needs a stiffness, or rigid: true");
  element.stiffness(0, 0) = stiffness->non_negative();
  if (const auto given = value.find("damping")) element.damping(0, 0) = given->non_negative();
  if (const auto given = value.find("preload")) element.preload(0) = given->number();
}

void read_hinge(const YamlReader& value, const Scene& scene, SceneElement& element) {
  if (scene.planar) {
    if (const auto given = value.find("axis")) {
      given->fail("a hinge of a planar scene turns about z and has none");
    }
    value.allow_only({"type", "nodes", "rigid", "stiffness", "damping", "preload"});
  } else {
    value.allow_only({"type", "nodes", "axis", "rigid", "stiffness", "damping", "preload"});
    element.axis = read_direction(value.require("axis"), scene);
    element.zero = {false, true, true};
  }
  if (const auto given = value.find("rigid")) element.zero = read_rigid(*given, element);
  if (const auto given = value.find("stiffness")) {
    element.stiffness = read_symmetric(*given, element, "stiffness");
  }
  if (const auto given = value.find("damping")) {
    element.damping = read_symmetric(*given, element, "damping");
  }
  if (const auto given = value.find("preload")) element.preload = read_preload(*given, element);
}

/// Into how many parts; more than the limit is a slip of the pen, not a model.
std::int64_t read_divide(const YamlReader& value) {
  constexpr std::int64_t limit = 10000;
  const auto given = value.find("divide");
  if (!given) return 1;
  const std::int64_t n = given->integer(1);
  if (n > limit) {
    given->fail("found " + given->text() + ", allowed is 1 to " + std::to_string(limit));
  }
  return n;
}

void read_element(const std::string& name, const YamlReader& value, Scene& scene) {
  refuse_slash(value, name);
  SceneElement element;
  element.name = name;
  element.place = value.place();
  element.kind = read_kind(value.require("type"));
  if (element.kind == Kind::superelement) {
    read_superelement(value, element, scene);
    scene.elements.push_back(element);
    return;
  }
  set_deformations(element, number_of_deformations(element.kind, scene.planar));
  const Ends ends = read_ends(value, scene, element);
  std::int64_t n_parts = 1;
  switch (element.kind) {
    case Kind::truss:
      read_truss(value, element);
      break;
    case Kind::beam:
      read_beam(value, scene, ends.p, ends.q, element);
      n_parts = read_divide(value);
      break;
    case Kind::rigid_beam:
      value.allow_only({"type", "nodes"});
      element.zero.assign(element.zero.size(), true);
      break;
    case Kind::hinge:
      read_hinge(value, scene, element);
      break;
    case Kind::superelement:
      break;
  }
  add_divided(element, n_parts, scene);
}

}  // namespace

void read_elements(const YamlReader& map, Scene& scene) {
  for (const auto& [name, value] : map.entries()) read_element(name, value, scene);
}

}  // namespace stillframe
