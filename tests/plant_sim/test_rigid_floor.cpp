#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>

#include "core/errors/input_error.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/floor/sources.hpp"
#include "plant_sim/floor_motion.hpp"

namespace stillframe {
namespace {

/// Three floor nodes, one of them moved along skew directions, one along z alone.
const char* const spatial = R"(
title: Three nodes on a floor
nodes:
  a: {position: [0.6, 0.2, -0.1]}
  b: {position: [-0.3, 0.5, -0.25]}
  c: {position: [0, -1, 0.4]}
  body: {position: [0, 0, 1]}
masses:
  - {node: body, mass: 2}
elements:
  leg_a: {type: truss, nodes: [a, body], stiffness: 1e4}
  leg_b: {type: truss, nodes: [b, body], stiffness: 1e4}
  leg_c: {type: truss, nodes: [c, body], stiffness: 1e4}
supports:
  - {nodes: [c], fix: [x, y]}
prescribed:
  - {nodes: [a], move: [x, y, z]}
  - {nodes: [b], move: [[3, 4, 0], [-4, 3, 0], z]}
  - {nodes: [c], move: [z]}
dofs: auto
inputs:
  - {name: w, acceleration: c, along: z}
)";

std::unique_ptr<floor::FloorSource> rigid(const Eigen::VectorXd& motion) {
  return std::make_unique<floor::TabulatedFloor>(floor::FloorChannels::rigid, motion);
}

TEST(RigidFloor, EveryNodeTurnsWithTheFloor) {
  const Scene scene = parse_scene(spatial, "scene.yaml");
  const Model model = make_model(scene);
  Eigen::VectorXd motion(6);
  motion << 1, -2, 3, 0.4, -0.5, 0.6;
  FloorMotion floor(rigid(motion), scene, model);
  floor.take(0);
  const Eigen::Vector3d theta = motion.tail<3>();
  for (const char* node : {"a", "b", "c"}) {
    const Index n = model.node_index(node);
    const Eigen::Vector3d r = model.nodes[static_cast<size_t>(n)].position;
    const Eigen::Vector3d expected = motion.head<3>() + theta.cross(r);
    for (int axis = 0; axis < 3; ++axis) {
      const auto row = model.translation_row(n, Eigen::Vector3d::Unit(axis));
      const bool held = std::string(node) == "c" && axis < 2;
      EXPECT_NEAR(row.tail(model.n_rx) * floor.floor_acceleration().head(model.n_rx),
                  held ? 0.0 : expected(axis), 1e-14);
    }
  }
}

TEST(RigidFloor, WhatLinearityLeavesOutIsOfTheOrderOfTheAngle) {
  const Scene scene = parse_scene(spatial, "scene.yaml");
  const Model model = make_model(scene);
  const Eigen::MatrixXd map = rigid_floor_map(model);
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -2) / 3;
  for (const double angle : {1e-6, 1e-4, 1e-2}) {
    Eigen::VectorXd motion = Eigen::VectorXd::Zero(6);
    motion.tail<3>() = angle * axis;
    const Eigen::VectorXd q_r = map * motion;
    for (const char* node : {"a", "b"}) {
      const Index n = model.node_index(node);
      const Eigen::Vector3d r = model.nodes[static_cast<size_t>(n)].position;
      const Eigen::Vector3d exact = Eigen::AngleAxisd(angle, axis) * r - r;
      Eigen::Vector3d u;
      for (int i = 0; i < 3; ++i) {
        u(i) = model.translation_row(n, Eigen::Vector3d::Unit(i)).tail(model.n_rx) *
               q_r.head(model.n_rx);
      }
      // theta x (theta x r) / 2 against theta x r: half an angle of it, and r rounds by 1e-16.
      EXPECT_LT((u - exact).norm(), 0.51 * angle * u.norm() + 2e-16);
      if (angle > 1e-5) {
        EXPECT_GT((u - exact).norm(), 0.49 * angle * u.norm());
      }
    }
  }
}

TEST(RigidFloor, InputsComeOnTopOfIt) {
  const Scene scene = parse_scene(spatial, "scene.yaml");
  const Model model = make_model(scene);
  Eigen::VectorXd motion = Eigen::VectorXd::Zero(7);
  motion(2) = 1.0;
  motion(6) = 10.0;
  FloorMotion floor(
      std::make_unique<floor::TabulatedFloor>(floor::FloorChannels::rigid_and_inputs, motion),
      scene, model);
  floor.take(0);
  Eigen::VectorXd along(1);
  floor.along_inputs(along);
  EXPECT_DOUBLE_EQ(along(0), 11.0);
  const auto row = model.translation_row(model.node_index("a"), Eigen::Vector3d::UnitZ());
  EXPECT_DOUBLE_EQ(row.tail(model.n_rx) * floor.floor_acceleration().head(model.n_rx), 1.0);
}

/// Two nodes joined by a hinge share their translation; a prescribed angle stands behind it in q^r.
const char* const hinged = R"(
title: A drive on a floor
nodes:
  ground: {position: [1, 2, 3]}
  arm: {position: [1, 2, 3]}
masses:
  - {node: arm, mass: 1, inertia: [1, 1, 1]}
elements:
  drive: {type: hinge, nodes: [ground, arm], axis: z, stiffness: 0}
supports:
  - {nodes: [ground], fix: [rotation]}
prescribed:
  - {nodes: [ground], move: [x, y, z]}
  - {element: drive}
dofs: []
)";

TEST(RigidFloor, NodesThatShareATranslationMoveOnce) {
  std::string text = hinged;
  // A scene has a dof: a mass on a spring beside the drive.
  text.replace(text.find("dofs: []"), 8, "dofs:\n  - {element: leg}");
  text.replace(text.find("  drive:"), 0,
               "  leg: {type: truss, nodes: [ground, bob], stiffness: 1}\n");
  text.replace(text.find("masses:"), 0, "  bob: {position: [1, 2, 4]}\n");
  text.replace(text.find("  - {node: arm"), 0, "  - {node: bob, mass: 1}\n");
  text.replace(text.find("prescribed:"), 0, "  - {nodes: [bob], fix: [x, y]}\n");
  const Scene scene = parse_scene(text, "scene.yaml");
  const Model model = make_model(scene);
  ASSERT_EQ(model.n_rx, 3);
  ASSERT_EQ(model.n_r, 4);
  Eigen::VectorXd motion = Eigen::VectorXd::Zero(6);
  motion.head<3>() << 1, 2, 3;
  FloorMotion floor(rigid(motion), scene, model);
  floor.take(0);
  EXPECT_EQ(floor.floor_acceleration(), Eigen::Vector4d(1, 2, 3, 0));
  // Its rotation is fixed: a floor that turns would leave it behind.
  try {
    FloorMotion turning(rigid(Eigen::VectorXd::Unit(6, 3)), scene, model);
    ADD_FAILURE() << "not refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("the floor turns and moves node 'ground', whose rotation is fixed"),
              std::string::npos)
        << error.what();
  }
  EXPECT_NO_THROW(FloorMotion(rigid(Eigen::VectorXd::Unit(6, 2)), scene, model));
}

const char* const planar = R"(
title: A strip on a floor in a plane
planar: true
nodes:
  clamp: {position: [2, 3]}
  tip: {position: [3, 3]}
masses: []
elements:
  strip: {type: beam, nodes: [clamp, tip], EA: 1e6, EI: 100, mass_per_length: 1}
prescribed:
  - {nodes: [clamp], move: [x, y, rotation]}
dofs:
  - {deformations: strip}
)";

TEST(RigidFloor, InAPlaneItTurnsAboutZ) {
  const Scene scene = parse_scene(planar, "scene.yaml");
  const Model model = make_model(scene);
  FloorMotion floor(rigid(Eigen::VectorXd::Unit(6, 5)), scene, model);
  floor.take(0);
  EXPECT_EQ(floor.floor_acceleration(), Eigen::Vector3d(-3, 2, 1));  // z x r, and the angle itself
  EXPECT_THROW(FloorMotion(rigid(Eigen::VectorXd::Unit(6, 3)), scene, model), InputError);
}

}  // namespace
}  // namespace stillframe
