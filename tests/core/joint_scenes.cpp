#include "tests/core/joint_scenes.hpp"

#include <cmath>

#include "tests/core/scenes.hpp"

namespace stillframe::test {

using Eigen::Vector3d;

namespace {

const std::string here = "joint scene";

Scene empty_scene(bool planar) {
  Scene scene;
  scene.title = scene.file = scene.dofs_place = here;
  scene.planar = planar;
  return scene;
}

void add_element(Scene& scene, SceneElement::Kind kind, const std::string& name,
                 const std::string& p, const std::string& q, const Vector3d& axis) {
  const bool hinge = kind == SceneElement::Kind::hinge;
  SceneElement element;
  element.name = name;
  element.place = here;
  element.kind = kind;
  element.node_p = p;
  element.node_q = q;
  element.n_deformations = hinge ? (scene.planar ? 1 : 3) : (scene.planar ? 3 : 6);
  element.zero.assign(static_cast<size_t>(element.n_deformations), true);
  if (hinge) element.zero[0] = false;
  element.stiffness = element.damping =
      Eigen::MatrixXd::Zero(element.n_deformations, element.n_deformations);
  element.preload = Eigen::VectorXd::Zero(element.n_deformations);
  element.axis = axis;
  scene.elements.push_back(element);
}

void add_hinge(Scene& scene, const std::string& name, const std::string& p, const std::string& q,
               const Vector3d& axis = Vector3d::UnitZ()) {
  add_element(scene, SceneElement::Kind::hinge, name, p, q, axis);
}
void add_link(Scene& scene, const std::string& name, const std::string& p, const std::string& q) {
  add_element(scene, SceneElement::Kind::rigid_beam, name, p, q, Vector3d::UnitZ());
}
void add_node(Scene& scene, const std::string& name, const Vector3d& at) {
  scene.nodes.push_back({name, here, at});
}

void fix(Scene& scene, const std::string& node, const std::vector<Vector3d>& directions,
         bool rotation) {
  SceneConstraint support;
  support.node = node;
  support.place = here;
  support.directions = directions;
  support.rotation = rotation;
  scene.supports.push_back(support);
}

void drive(Scene& scene, const std::string& element) {
  SceneConstraint motion;
  motion.element = element;
  motion.place = here;
  motion.mode = 1;
  scene.prescribed.push_back(motion);
}

void add_mass(Scene& scene, const std::string& node) {
  const Eigen::Matrix3d J = Vector3d(0.02, 0.03, 0.04).asDiagonal();
  scene.masses.push_back({node, here, 1.5, J, true});
}

std::vector<Vector3d> axes(bool planar) {
  if (planar) return {Vector3d::UnitX(), Vector3d::UnitY()};
  return {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
}

}  // namespace

Vector3d chain_axis(int i) {
  return Vector3d(std::cos(1.3 * i), std::sin(1.3 * i), 0.5 * std::cos(0.7 * i)).normalized();
}
Vector3d chain_link(int i) { return {0.3 * std::sin(0.9 * i), 0.2, 0.3 * std::cos(0.9 * i)}; }

Scene hinge_chain(int links, bool drive_first) {
  Scene scene = empty_scene(false);
  Vector3d at(0.2, -0.1, 0.4);
  add_node(scene, "base", at);
  fix(scene, "base", axes(false), true);
  std::string before = "base";
  for (int i = 1; i <= links; ++i) {
    const std::string n = std::to_string(i);
    add_node(scene, "start_" + n, at);
    at += chain_link(i);
    add_node(scene, "end_" + n, at);
    add_hinge(scene, "hinge_" + n, before, "start_" + n, chain_axis(i));
    add_link(scene, "link_" + n, "start_" + n, "end_" + n);
    add_mass(scene, "end_" + n);
    before = "end_" + n;
    if (i == 1 && drive_first) {
      drive(scene, "hinge_1");
    } else {
      scene.dofs.push_back(dof_of_element("hinge_" + n));
    }
  }
  return scene;
}

Scene spinning_rotor() {
  Scene scene = empty_scene(false);
  for (const char* node : {"base", "start_1", "start_2"}) add_node(scene, node, Vector3d::Zero());
  fix(scene, "base", axes(false), true);
  add_hinge(scene, "hinge_1", "base", "start_1", chain_axis(1));
  add_hinge(scene, "hinge_2", "start_1", "start_2", chain_axis(2));
  add_mass(scene, "start_1");
  add_mass(scene, "start_2");
  drive(scene, "hinge_1");
  scene.dofs = {dof_of_element("hinge_2")};
  return scene;
}

Scene slider_crank() {
  Scene scene = empty_scene(true);
  const Vector3d pin(0.3 * std::cos(0.5), 0.3 * std::sin(0.5), 0);
  add_node(scene, "base", Vector3d::Zero());
  add_node(scene, "crank", Vector3d::Zero());
  add_node(scene, "pin", pin);
  add_node(scene, "rod", pin);
  add_node(scene, "slider", {pin.x() + std::sqrt(0.64 - pin.y() * pin.y()), 0, 0});
  fix(scene, "base", axes(true), true);
  fix(scene, "slider", {Vector3d::UnitY()}, false);
  add_hinge(scene, "motor", "base", "crank");
  add_link(scene, "crank_link", "crank", "pin");
  add_hinge(scene, "pin_hinge", "pin", "rod");
  add_link(scene, "rod_link", "rod", "slider");
  add_mass(scene, "slider");
  scene.dofs = {dof_of_element("motor")};
  return scene;
}

Scene four_bar() {
  Scene scene = empty_scene(true);
  const Vector3d pin(0.1, 0.3, 0), knee(0.9, 0.75, 0), far(1, 0.1, 0);
  for (const auto& [name, at] : {std::pair<const char*, Vector3d>("base", Vector3d::Zero()),
                                 {"crank", Vector3d::Zero()},
                                 {"pin", pin},
                                 {"coupler", pin},
                                 {"knee", knee},
                                 {"rocker", knee},
                                 {"rocker_foot", far},
                                 {"far_base", far}}) {
    add_node(scene, name, at);
  }
  fix(scene, "base", axes(true), true);
  fix(scene, "far_base", axes(true), true);
  add_hinge(scene, "motor", "base", "crank");
  add_link(scene, "crank_link", "crank", "pin");
  add_hinge(scene, "pin_hinge", "pin", "coupler");
  add_link(scene, "coupler_link", "coupler", "knee");
  add_hinge(scene, "knee_hinge", "knee", "rocker");
  add_link(scene, "rocker_link", "rocker", "rocker_foot");
  add_hinge(scene, "foot_hinge", "rocker_foot", "far_base");
  add_mass(scene, "knee");
  scene.dofs = {dof_of_element("motor")};
  return scene;
}

}  // namespace stillframe::test
