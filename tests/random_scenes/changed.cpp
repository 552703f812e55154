#include "tests/random_scenes/changed.hpp"

#include <algorithm>

namespace stillframe::random_scenes {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Scene moved(Scene scene, const Matrix3d& Q, const Vector3d& t) {
  for (SceneNode& node : scene.nodes) node.position = Q * node.position + t;
  for (SceneMass& mass : scene.masses) {
    const Matrix3d J = Q * mass.inertia * Q.transpose();
    if (!scene.planar) mass.inertia = 0.5 * (J + J.transpose());
  }
  for (auto* list : {&scene.supports, &scene.prescribed}) {
    for (SceneConstraint& item : *list) {
      for (Vector3d& d : item.directions) d = Q * d;
    }
  }
  for (SceneDof& dof : scene.dofs) {
    if (dof.direction) dof.direction = Q * *dof.direction;
  }
  scene.gravity = Q * scene.gravity;
  for (SceneElement& element : scene.elements) {
    element.axis = Q * element.axis;
    element.beam.orientation = Q * element.beam.orientation;
  }
  for (SceneLoad& load : scene.loads) {
    load.force = Q * load.force;
    load.torque = Q * load.torque;
  }
  for (auto* list : {&scene.inputs, &scene.outputs, &scene.monitors}) {
    for (SceneSignal& signal : *list) signal.direction = Q * signal.direction;
  }
  return scene;
}

Scene renumbered(Scene scene, Draws& draws) {
  const auto shuffle = [&draws](auto& items) {
    for (size_t i = items.size(); i > 1; --i) {
      std::swap(items[i - 1], items[static_cast<size_t>(draws.below(static_cast<int>(i)))]);
    }
  };
  shuffle(scene.nodes);
  shuffle(scene.elements);
  shuffle(scene.masses);
  shuffle(scene.supports);
  shuffle(scene.prescribed);
  shuffle(scene.loads);
  shuffle(scene.dofs);
  for (SceneElement& element : scene.elements) {
    if (element.kind == SceneElement::Kind::truss) std::swap(element.node_p, element.node_q);
  }
  const auto rename = [](std::string& name) {
    if (!name.empty()) name = "other_" + name;
  };
  for (SceneNode& node : scene.nodes) rename(node.name);
  for (SceneMass& mass : scene.masses) rename(mass.node);
  for (SceneElement& element : scene.elements) {
    for (std::string* name : {&element.name, &element.node_p, &element.node_q}) rename(*name);
  }
  for (auto* list : {&scene.supports, &scene.prescribed}) {
    for (SceneConstraint& item : *list) rename(item.node), rename(item.element);
  }
  for (SceneDof& dof : scene.dofs) rename(dof.node), rename(dof.element);
  for (SceneLoad& load : scene.loads) rename(load.node);
  for (auto* list : {&scene.inputs, &scene.outputs, &scene.monitors}) {
    for (SceneSignal& signal : *list) rename(signal.node), rename(signal.element);
  }
  if (scene.controller) {
    for (std::string& leg : scene.controller->legs) rename(leg);
  }
  return scene;
}

Scene in_units(Scene scene, const Units& units) {
  const double L = units.length, T = units.time, inertia = units.mass * L * L;
  const double force = units.mass * L / (T * T), moment = force * L;
  for (SceneNode& node : scene.nodes) node.position *= L;
  for (SceneMass& mass : scene.masses) {
    mass.mass *= units.mass;
    mass.inertia *= inertia;
  }
  const auto is_hinge = [&scene](const std::string& name) {
    return std::any_of(scene.elements.begin(), scene.elements.end(), [&](const auto& element) {
      return element.name == name && element.kind == SceneElement::Kind::hinge;
    });
  };
  for (SceneElement& element : scene.elements) {
    const bool hinge = element.kind == SceneElement::Kind::hinge;
    const double stress = hinge ? moment : force, stiffness = stress / (hinge ? 1 : L);
    element.stiffness *= stiffness;
    element.damping *= stiffness * T;
    element.preload *= stress;
    SceneBeam& beam = element.beam;
    for (double* value : {&beam.EA, &beam.shear_y, &beam.shear_z}) *value *= force;
    for (double* value : {&beam.GJ, &beam.EI_y, &beam.EI_z}) *value *= moment * L;
    beam.mass_per_length *= units.mass / L;
    beam.inertia_per_length *= inertia / L;
    beam.damping_time *= T;
  }
  for (SceneConstraint& item : scene.prescribed) {
    const double size = is_hinge(item.element) || item.rotation ? 1 : L;
    item.value *= size;
    item.rate *= size / T;
    item.acceleration *= size / (T * T);
  }
  scene.gravity *= L / (T * T);
  if (scene.modal_damping) {
    for (auto& point : scene.modal_damping->points) point.hz /= T;
  }
  for (SceneLoad& load : scene.loads) {
    load.force *= force;
    load.torque *= moment;
  }
  if (scene.controller) {
    SceneController& block = *scene.controller;
    for (double& hz : block.target_hz) hz /= T;
    for (double* hz : {&block.sample_rate_hz, &block.leak_hz, &block.high_pass_hz}) *hz /= T;
    if (block.roll_off_hz) *block.roll_off_hz /= T;
    if (block.force_limit_n) *block.force_limit_n *= force;
  }
  scene.instruments.actuator_lag_hz /= T;
  scene.instruments.sensor_filter_hz /= T;
  return scene;
}

}  // namespace stillframe::random_scenes
