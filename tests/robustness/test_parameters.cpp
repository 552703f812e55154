#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <set>

#include "core/mechanics/model/model.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "tests/robustness/frame.hpp"

namespace stillframe::robustness {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Kind = Parameter::Kind;

SceneUncertainty everything() {
  SceneUncertainty uncertainty;
  uncertainty.stiffness = 0.1;
  uncertainty.mass = 0.02;
  uncertainty.inertia = 0.05;
  uncertainty.centre_of_mass_m = 0.005;
  uncertainty.leg_direction_rad = 0.02;
  uncertainty.actuator_gain = 0.1;
  uncertainty.damping = 0.15;  // of which no leg has any
  uncertainty.sensor_gain = 0.07;
  uncertainty.delay_samples = 0.3;
  return uncertainty;
}

const FrameLoop& frame() {
  static const FrameLoop loop;
  return loop;
}

PerturbedPlant changed(const std::vector<Parameter>& list, const std::string& name, double value) {
  for (size_t j = 0; j < list.size(); ++j) {
    if (name_of(list[j]) != name) continue;
    const auto p = static_cast<Eigen::Index>(list.size());
    return perturbed(frame().scene, frame().sampling, list,
                     only(p, static_cast<Eigen::Index>(j), value));
  }
  ADD_FAILURE() << "no parameter " << name;
  return {};
}

const SceneNode& node(const Scene& scene, const std::string& name) {
  return *std::find_if(scene.nodes.begin(), scene.nodes.end(),
                       [&](const SceneNode& n) { return n.name == name; });
}

/// Names of the nodes that stand elsewhere in the two scenes.
std::set<std::string> moved_nodes(const Scene& a, const Scene& b) {
  std::set<std::string> names;
  for (size_t i = 0; i < a.nodes.size(); ++i) {
    if (a.nodes[i].position != b.nodes[i].position) names.insert(a.nodes[i].name);
  }
  return names;
}

TEST(Parameters, OneForEachUncertainThing) {
  // 6 stiffnesses, mass, inertia, 3 of the centre of mass, 2 directions and 2 gains a leg, the
  // delay.
  EXPECT_EQ(parameters_of(frame().scene, everything()).size(), 6u + 1 + 1 + 3 + 12 + 6 + 6 + 1);
  EXPECT_TRUE(parameters_of(frame().scene, {}).empty());
  for (const Parameter& parameter : parameters_of(frame().scene, everything())) {
    SceneUncertainty others = everything();
    double* const sizes[] = {
        &others.stiffness,     &others.damping,          &others.mass,
        &others.inertia,       &others.centre_of_mass_m, &others.leg_direction_rad,
        &others.actuator_gain, &others.sensor_gain,      &others.delay_samples};
    EXPECT_EQ(parameter.size, *sizes[static_cast<size_t>(parameter.kind)]);
    *sizes[static_cast<size_t>(parameter.kind)] = 0;
    for (const Parameter& other : parameters_of(frame().scene, others)) {
      EXPECT_NE(other.kind, parameter.kind);
    }
  }
}

TEST(Parameters, InWords) {
  const auto list = parameters_of(frame().scene, everything());
  std::set<std::string> words;
  for (const Parameter& parameter : list) words.insert(describe(parameter, -0.5));
  EXPECT_EQ(words.size(), list.size());
  for (const char* text : {"leg_1v stiffness -5 %", "lens mass -1 %", "lens inertia -2.5 %",
                           "lens centre of mass along z -2.5 mm", "leg_1t foot towards x -10 mrad",
                           "leg_3v actuator gain -5 %", "delay -0.15 samples"}) {
    EXPECT_TRUE(words.contains(text)) << text;
  }
}

TEST(Parameters, EachChangesWhatItSaysAndNothingElse) {
  const auto list = parameters_of(frame().scene, everything());
  const Scene& as_is = frame().scene;

  const Scene stiffer = changed(list, "leg_1v stiffness", 1).scene;
  for (size_t i = 0; i < as_is.elements.size(); ++i) {
    if (as_is.elements[i].rigid()) continue;
    const double factor = as_is.elements[i].name == "leg_1v" ? 1.1 : 1.0;
    EXPECT_DOUBLE_EQ(stiffer.elements[i].stiffness(0, 0), 3.95e6 * factor);
  }
  EXPECT_DOUBLE_EQ(changed(list, "lens mass", -1).scene.masses[0].mass, 750 * 0.98);
  EXPECT_EQ(changed(list, "lens mass", -1).scene.masses[0].inertia, as_is.masses[0].inertia);
  EXPECT_DOUBLE_EQ(changed(list, "lens inertia", 1).scene.masses[0].inertia(2, 2), 45 * 1.05);

  const Scene shifted = changed(list, "lens centre of mass along y", 1).scene;
  EXPECT_EQ(node(shifted, "lens").position, Vector3d(0, 0.005, 0));
  EXPECT_EQ(moved_nodes(as_is, shifted), std::set<std::string>{"lens"});

  const PerturbedPlant gained = changed(list, "leg_2t actuator gain", 1);
  const VectorXd gains = (VectorXd(6) << 1, 1, 1.1, 1, 1, 1).finished();
  EXPECT_TRUE(gained.sampling.leg_gains.isApprox(gains, 1e-15));
  EXPECT_EQ(moved_nodes(as_is, gained.scene), std::set<std::string>{});
  EXPECT_DOUBLE_EQ(changed(list, "delay", 1).sampling.delay_samples, 1.3);
}

TEST(Parameters, ALegTurnsAboutItsEndAtTheFrame) {
  const auto list = parameters_of(frame().scene, everything());
  for (const Parameter& parameter : list) {
    if (parameter.kind != Kind::leg_direction) continue;
    const Scene turned = changed(list, name_of(parameter), -1).scene;
    const std::string foot = "floor_" + parameter.subject.substr(4);
    const std::string top = "mount_" + parameter.subject.substr(4, 1);
    EXPECT_EQ(moved_nodes(frame().scene, turned), std::set<std::string>{foot});
    const Vector3d before = node(frame().scene, foot).position - node(frame().scene, top).position;
    const Vector3d after = node(turned, foot).position - node(turned, top).position;
    // Rounding of positions of 0.6 m.
    EXPECT_NEAR(after.norm(), before.norm(), 1e-15);
    EXPECT_NEAR(parameter.direction.dot(before), 0, 1e-15);
    const double sine = before.cross(after).norm() / before.squaredNorm();
    EXPECT_NEAR(std::asin(sine), 0.02, 1e-13);
    EXPECT_NEAR(after.dot(parameter.direction), -before.norm() * std::sin(0.02), 1e-15);
  }
}

TEST(Parameters, BothTurnsOfALegAreOneRotation) {
  SceneUncertainty uncertainty;
  uncertainty.leg_direction_rad = 0.3;
  const auto list = parameters_of(frame().scene, uncertainty);
  VectorXd values = VectorXd::Zero(12);
  values.head(2) << 0.6, 0.8;
  const Scene turned = perturbed(frame().scene, frame().sampling, list, values).scene;
  const Vector3d before(0, -0.15, 0),
      after = node(turned, "floor_1t").position - node(turned, "mount_1").position;
  const Vector3d expected =
      std::cos(0.3) * before +
      0.15 * std::sin(0.3) * (0.6 * list[0].direction + 0.8 * list[1].direction);
  EXPECT_LT((after - expected).norm(), 1e-15);
}

TEST(Parameters, TheDelayGoesNoLowerThanZero) {
  SceneUncertainty uncertainty;
  uncertainty.delay_samples = 2;
  const auto list = parameters_of(frame().scene, uncertainty);
  EXPECT_EQ(changed(list, "delay", -1).sampling.delay_samples, 0);
  EXPECT_EQ(changed(list, "delay", -0.25).sampling.delay_samples, 0.5);
}

TEST(Parameters, NodesThatHingesJoinMoveTogether) {
  const Scene scene = parse_scene(R"(title: A body on a hinged arm
planar: true
nodes:
  ground: {position: [0, 0]}
  arm: {position: [1, 0]}
  body: {position: [1, 0]}
  foot: {position: [0.5, -1]}
  knee: {position: [0.5, 0]}
masses:
  - {node: body, mass: 1, inertia: 1}
elements:
  inner: {type: rigid_beam, nodes: [ground, knee]}
  outer: {type: rigid_beam, nodes: [knee, arm]}
  joint: {type: hinge, nodes: [arm, body], stiffness: 1}
  leg: {type: truss, nodes: [knee, foot], stiffness: 800}
supports:
  - {nodes: [ground, foot], fix: [x, y]}
dofs: [{element: leg}, {element: joint}]
controller:
  {legs: [leg], target_hz: 1, damping_ratio: 0.7, sample_rate_hz: 100, delay_samples: 0, leak_hz: 0}
)",
                                  "scene");
  SceneUncertainty uncertainty;
  uncertainty.centre_of_mass_m = 0.1;
  uncertainty.leg_direction_rad = 0.1;
  const auto list = parameters_of(scene, uncertainty);
  ASSERT_EQ(list.size(), 3u);  // a planar scene: x and y, and one direction across the leg
  EXPECT_EQ(name_of(list[2]), "leg foot towards x");
  const Scene shifted = perturbed(scene, {}, list, only(3, 1, 1)).scene;
  EXPECT_EQ(moved_nodes(scene, shifted), (std::set<std::string>{"arm", "body"}));
  EXPECT_EQ(node(shifted, "arm").position, Vector3d(1, 0.1, 0));
  const Scene turned = perturbed(scene, {}, list, only(3, 2, 1)).scene;
  EXPECT_EQ(moved_nodes(scene, turned), std::set<std::string>{"foot"});
}

TEST(Parameters, DampersStayWhereStiffnessChanges) {
  const Scene scene = parse_scene(R"(title: A mass on a damped beam
planar: true
nodes:
  ground: {position: [0, 0]}
  mass: {position: [1, 0]}
masses:
  - {node: mass, mass: 1, inertia: 1}
elements:
  leg: {type: beam, nodes: [ground, mass], EA: 4e4, damping_time: 5e-4, rigid: [2, 3]}
supports:
  - {nodes: [ground], fix: [x, y, rotation]}
dofs: [{element: leg, mode: 1}]
inputs:
  - {name: push, force: mass, along: x}
controller:
  {legs: [leg], target_hz: 1, damping_ratio: 0.7, sample_rate_hz: 100, delay_samples: 0, leak_hz: 0}
)",
                                  "scene");
  SceneUncertainty uncertainty;
  uncertainty.stiffness = 0.5;
  const auto list = parameters_of(scene, uncertainty);
  ASSERT_EQ(list.size(), 1u);
  const Model as_is = make_model(scene),
              stiffer = make_model(perturbed(scene, {}, list, only(1, 0, 1)).scene);
  EXPECT_DOUBLE_EQ(stiffer.elements.back().S(0, 0), 1.5 * as_is.elements.back().S(0, 0));
  EXPECT_DOUBLE_EQ(stiffer.elements.back().S_d(0, 0), as_is.elements.back().S_d(0, 0));
  EXPECT_DOUBLE_EQ(as_is.elements.back().S_d(0, 0), 4e4 * 5e-4);
}

TEST(Parameters, RefusesTheWrongNumberOfValues) {
  EXPECT_THROW(perturbed(frame().scene, frame().sampling, {}, VectorXd::Zero(1)),
               std::invalid_argument);
}

}  // namespace
}  // namespace stillframe::robustness
