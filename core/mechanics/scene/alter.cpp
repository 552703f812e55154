#include "core/mechanics/scene/alter.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace stillframe {

using Eigen::Vector3d;

namespace {

template <class Named>
size_t index_of_name(const std::vector<Named>& list, const std::string& name) {
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const Named& each) { return each.name == name; });
  if (found == list.end()) throw std::out_of_range("no node or element is named '" + name + "'");
  return static_cast<size_t>(found - list.begin());
}

/// The one of a direction and its opposite whose largest component is positive.
Vector3d upward(const Vector3d& direction) {
  Eigen::Index largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  return direction(largest) < 0 ? Vector3d(-direction) : direction;
}

}  // namespace

size_t node_index(const Scene& scene, const std::string& name) {
  return index_of_name(scene.nodes, name);
}

size_t element_index(const Scene& scene, const std::string& name) {
  return index_of_name(scene.elements, name);
}

size_t directions_held(const Scene& scene, const std::string& node) {
  size_t count = 0;
  for (const auto* list : {&scene.supports, &scene.prescribed}) {
    for (const SceneConstraint& constraint : *list) {
      if (constraint.node == node) count += constraint.directions.size();
    }
  }
  return count;
}

SceneLeg leg_of(const Scene& scene, const std::string& name) {
  const SceneElement& element = scene.elements[element_index(scene, name)];
  const bool second =
      directions_held(scene, element.node_q) > directions_held(scene, element.node_p);
  SceneLeg leg;
  leg.foot = node_index(scene, second ? element.node_q : element.node_p);
  leg.top = node_index(scene, second ? element.node_p : element.node_q);
  leg.span = scene.nodes[leg.foot].position - scene.nodes[leg.top].position;
  return leg;
}

std::vector<Vector3d> across(const Vector3d& span, bool planar) {
  const Vector3d n = span.normalized();
  if (planar) return {upward(Vector3d::UnitZ().cross(n))};
  Eigen::Index least = 0;
  n.cwiseAbs().minCoeff(&least);
  const Vector3d axis = Vector3d::Unit(least), first = (axis - n.dot(axis) * n).normalized();
  return {first, upward(n.cross(first))};
}

void scale_stiffness(SceneElement& element, double factor) {
  element.stiffness *= factor;
  SceneBeam& beam = element.beam;
  for (double* value : {&beam.EA, &beam.GJ, &beam.EI_y, &beam.EI_z, &beam.shear_y, &beam.shear_z}) {
    *value *= factor;
  }
  beam.damping_time /= factor;  // dampers stay
}

void scale_damping(SceneElement& element, double factor) {
  element.damping *= factor;
  element.beam.damping_time *= factor;
}

bool is_damped(const SceneElement& element) {
  return (element.damping.size() > 0 && !element.damping.isZero(0)) ||
         element.beam.damping_time != 0;
}

bool is_stiff(const SceneElement& element) {
  const SceneBeam& beam = element.beam;
  return (element.stiffness.size() > 0 && !element.stiffness.isZero(0)) || beam.EA != 0 ||
         beam.GJ != 0 || beam.EI_y != 0 || beam.EI_z != 0;
}

void move_node(Scene& scene, size_t node, const Vector3d& displacement) {
  std::vector<size_t> moving{node};
  for (size_t i = 0; i < moving.size(); ++i) {
    const std::string name = scene.nodes[moving[i]].name;
    scene.nodes[moving[i]].position += displacement;
    for (const SceneElement& element : scene.elements) {
      if (element.kind != SceneElement::Kind::hinge) continue;
      if (element.node_p != name && element.node_q != name) continue;
      const size_t other =
          node_index(scene, element.node_p == name ? element.node_q : element.node_p);
      if (std::find(moving.begin(), moving.end(), other) == moving.end()) moving.push_back(other);
    }
  }
}

void turn_leg(Scene& scene, const SceneLeg& leg, const Vector3d& angle) {
  const double theta = angle.norm(), length = leg.span.norm();
  if (theta == 0) return;
  // 1 - cos theta as 2 sin^2(theta / 2), which keeps its digits for small angles.
  const double half = std::sin(theta / 2);
  move_node(scene, leg.foot, length * std::sin(theta) / theta * angle - 2 * half * half * leg.span);
}

}  // namespace stillframe
