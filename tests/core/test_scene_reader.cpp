#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/mechanics/scene/scene_reader.hpp"
#include "tests/core/reader_scenes.hpp"

// What the reader makes of every kind of key. What it refuses is in test_scene_errors.cpp.
namespace stillframe::test {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Kind = SceneElement::Kind;

const SceneElement& element(const Scene& scene, const std::string& name) {
  const auto found = std::find_if(scene.elements.begin(), scene.elements.end(),
                                  [&](const SceneElement& e) { return e.name == name; });
  if (found == scene.elements.end()) throw std::runtime_error("no element " + name);
  return *found;
}

Vector3d position(const Scene& scene, const std::string& name) {
  const auto found = std::find_if(scene.nodes.begin(), scene.nodes.end(),
                                  [&](const SceneNode& node) { return node.name == name; });
  if (found == scene.nodes.end()) throw std::runtime_error("no node " + name);
  return found->position;
}

/// "name.mode" of every dof, or "node" of a nodal one.
std::vector<std::string> names_of_dofs(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneDof& dof : scene.dofs) {
    names.push_back(dof.node.empty() ? dof.element + "." + std::to_string(dof.mode) : dof.node);
  }
  return names;
}

class SpatialScene : public testing::Test {
 protected:
  const Scene scene = parse_scene(every_spatial_key, "crane.yaml");
};

class PlanarScene : public testing::Test {
 protected:
  const Scene scene = parse_scene(every_planar_key, "crank.yaml");
};

TEST_F(SpatialScene, SaysWhereItIsLookedAt) {
  EXPECT_FALSE(scene.planar);
  EXPECT_EQ(scene.gravity, Vector3d(0, 0, -9.81));
  EXPECT_EQ(scene.operating_point, OperatingPoint::equilibrium);
  EXPECT_FALSE(scene.automatic_dofs);
  EXPECT_EQ(scene.dofs_place, "crane.yaml:33:3");
}

TEST_F(SpatialScene, SectionOfABeam) {
  const SceneElement& mast = element(scene, "mast");
  EXPECT_EQ(mast.kind, Kind::beam);
  EXPECT_EQ(mast.node_p, "foot");
  EXPECT_EQ(mast.node_q, "top");
  EXPECT_EQ(mast.n_deformations, 6);
  EXPECT_EQ(mast.zero, std::vector<bool>(6, false));
  EXPECT_EQ(mast.stiffness, MatrixXd::Zero(6, 6));
  EXPECT_EQ(mast.damping, MatrixXd::Zero(6, 6));
  EXPECT_EQ(mast.preload, (Eigen::VectorXd(6) << -20, 0, 0, 0, 0, 1).finished());
  const SceneBeam& beam = mast.beam;
  EXPECT_EQ(beam.EA, 1e7);
  EXPECT_EQ(beam.GJ, 2e4);
  EXPECT_EQ(beam.EI_y, 3e4);
  EXPECT_EQ(beam.EI_z, 4e4);
  EXPECT_EQ(beam.shear_y, 5e6);
  EXPECT_EQ(beam.shear_z, 6e6);
  EXPECT_EQ(beam.mass_per_length, 7);
  EXPECT_EQ(beam.inertia_per_length, 0.08);
  EXPECT_EQ(beam.damping_time, 1e-3);
  EXPECT_TRUE(beam.lumped_mass);
  EXPECT_TRUE(beam.second_order);
  EXPECT_EQ(beam.orientation, Vector3d::UnitY());
}

TEST_F(SpatialScene, DividedBeamIsARowOfEqualParts) {
  // [3, 0.5, 1] - [0, 0, 1] in quarters: all numbers are binary fractions, so equal to the last
  // bit.
  EXPECT_EQ(position(scene, "boom/1"), Vector3d(0.75, 0.125, 1));
  EXPECT_EQ(position(scene, "boom/2"), Vector3d(1.5, 0.25, 1));
  EXPECT_EQ(position(scene, "boom/3"), Vector3d(2.25, 0.375, 1));
  EXPECT_THROW(position(scene, "boom/4"), std::runtime_error);
  EXPECT_THROW(element(scene, "boom"), std::runtime_error);
  const std::string nodes[] = {"jib", "boom/1", "boom/2", "boom/3", "tip"};
  for (int i = 1; i <= 4; ++i) {
    const SceneElement& part = element(scene, "boom/" + std::to_string(i));
    EXPECT_EQ(part.node_p, nodes[i - 1]);
    EXPECT_EQ(part.node_q, nodes[i]);
    EXPECT_EQ(part.kind, Kind::beam);
    EXPECT_EQ(part.zero, (std::vector<bool>{true, true, false, false, false, false}));
    EXPECT_EQ(part.beam.EA, 0);
    EXPECT_EQ(part.beam.EI_y, 1e4);
    EXPECT_EQ(part.beam.orientation, Vector3d::UnitZ());
    EXPECT_EQ(part.preload, (Eigen::VectorXd(6) << 0, 0, 1, 2, 3, 4).finished());
    EXPECT_EQ(part.place, element(scene, "boom/1").place);
  }
  EXPECT_THROW(element(scene, "boom/5"), std::runtime_error);
  EXPECT_EQ(scene.masses[1].node, "boom/1");
}

TEST_F(SpatialScene, DefaultsOfABeam) {
  const SceneBeam& beam = element(scene, "boom/1").beam;
  EXPECT_EQ(beam.shear_y, 0);
  EXPECT_EQ(beam.shear_z, 0);
  EXPECT_EQ(beam.mass_per_length, 0);
  EXPECT_EQ(beam.inertia_per_length, 0);
  EXPECT_EQ(beam.damping_time, 0);
  EXPECT_FALSE(beam.lumped_mass);
  EXPECT_FALSE(beam.second_order);
}

TEST_F(SpatialScene, RigidElementsHoldAllDeformations) {
  for (const char* name : {"rod", "arm"}) {
    EXPECT_EQ(element(scene, name).zero, std::vector<bool>(6, true)) << name;
    EXPECT_TRUE(element(scene, name).rigid()) << name;
  }
  EXPECT_EQ(element(scene, "rod").kind, Kind::beam);
  EXPECT_EQ(element(scene, "rod").beam.mass_per_length, 2);
  EXPECT_EQ(element(scene, "arm").kind, Kind::rigid_beam);
  EXPECT_TRUE(element(scene, "stay").rigid());
  EXPECT_FALSE(element(scene, "cable").rigid());
}

TEST_F(SpatialScene, NumbersOfAHinge) {
  const SceneElement& pivot = element(scene, "pivot");
  EXPECT_EQ(pivot.kind, Kind::hinge);
  EXPECT_EQ(pivot.axis, Vector3d::UnitY());
  EXPECT_EQ(pivot.zero, (std::vector<bool>{false, true, true}));
  EXPECT_EQ(pivot.stiffness, MatrixXd(Vector3d(100, 0, 0).asDiagonal()));
  EXPECT_EQ(pivot.damping, MatrixXd(Vector3d(2, 0, 0).asDiagonal()));
  EXPECT_EQ(pivot.preload, Vector3d(5, 0, 0));
  const SceneElement& ball = element(scene, "ball");
  EXPECT_EQ(ball.zero, std::vector<bool>(3, false));
  EXPECT_EQ(ball.stiffness, MatrixXd(Vector3d(1, 2, 3).asDiagonal()));
  EXPECT_EQ(ball.damping, (Matrix3d() << 2, 1, 0, 1, 2, 0, 0, 0, 0).finished());
  EXPECT_EQ(ball.preload, Vector3d(1, 2, 3));
  const SceneElement& wrist = element(scene, "wrist");  // one number: the one that is not rigid
  EXPECT_EQ(wrist.zero, (std::vector<bool>{true, false, true}));
  EXPECT_EQ(wrist.stiffness, MatrixXd(Vector3d(0, 7, 0).asDiagonal()));
  EXPECT_EQ(wrist.preload, Vector3d(0, 5, 0));
}

TEST_F(SpatialScene, NumbersOfATruss) {
  const SceneElement& cable = element(scene, "cable");
  EXPECT_EQ(cable.n_deformations, 1);
  EXPECT_EQ(cable.stiffness, MatrixXd::Constant(1, 1, 1e5));
  EXPECT_EQ(cable.damping, MatrixXd::Constant(1, 1, 3));
  EXPECT_EQ(cable.preload, Eigen::VectorXd::Constant(1, 40));
}

TEST_F(SpatialScene, Constraints) {
  ASSERT_EQ(scene.supports.size(), 2u);
  EXPECT_EQ(scene.supports[1].node, "anchor");
  EXPECT_TRUE(scene.supports[1].rotation);
  ASSERT_EQ(scene.supports[1].directions.size(), 2u);
  EXPECT_TRUE(scene.supports[1].directions[1].isApprox(Vector3d(0, 0.6, 0.8), 1e-15));  // rounding
  ASSERT_EQ(scene.prescribed.size(), 4u);
  for (int i : {0, 1}) {
    const SceneConstraint& motion = scene.prescribed[static_cast<size_t>(i)];
    EXPECT_EQ(motion.node, i == 0 ? "foot" : "anchor");
    EXPECT_EQ(motion.directions, (std::vector<Vector3d>{Vector3d::UnitZ(), Vector3d::UnitX()}));
    EXPECT_EQ(motion.value, 0.1);
    EXPECT_EQ(motion.rate, 0.2);
    EXPECT_EQ(motion.acceleration, 0.3);
    EXPECT_EQ(motion.element, "");
  }
  EXPECT_EQ(scene.prescribed[2].element, "pivot");
  EXPECT_EQ(scene.prescribed[2].mode, 1);
  EXPECT_EQ(scene.prescribed[2].value, 0);
  EXPECT_EQ(scene.prescribed[2].rate, 10);
  EXPECT_EQ(scene.prescribed[2].node, "");
  EXPECT_EQ(scene.prescribed[3].element, "boom/2");
  EXPECT_EQ(scene.prescribed[3].mode, 6);
}

TEST_F(SpatialScene, DeformationsTakeAllThatAreNotRigidOfAllParts) {
  std::vector<std::string> expected = {"mast.1", "mast.2", "mast.3", "mast.4", "mast.5", "mast.6"};
  for (int part = 1; part <= 4; ++part) {
    for (int mode = 3; mode <= 6; ++mode) {
      expected.push_back("boom/" + std::to_string(part) + "." + std::to_string(mode));
    }
  }
  for (const char* name : {"pivot.1", "cable.1", "pivot.1", "ball.3", "boom/4.5", "tip", "tip"}) {
    expected.push_back(name);
  }
  EXPECT_EQ(names_of_dofs(scene), expected);
  const SceneDof& along = scene.dofs[scene.dofs.size() - 2];
  EXPECT_EQ(along.direction, -Vector3d::UnitZ());
  EXPECT_EQ(along.euler_parameter, -1);
  EXPECT_EQ(scene.dofs.back().euler_parameter, 0);
  EXPECT_FALSE(scene.dofs.back().direction);
}

TEST_F(SpatialScene, Loads) {
  ASSERT_EQ(scene.loads.size(), 2u);
  EXPECT_EQ(scene.loads[0].force, Vector3d(1, 2, 3));
  EXPECT_EQ(scene.loads[0].torque, Vector3d(4, 5, 6));
  EXPECT_TRUE(scene.loads[0].follows);
  EXPECT_EQ(scene.loads[1].force, Vector3d::Zero());
  EXPECT_EQ(scene.loads[1].torque, Vector3d::UnitZ());
  EXPECT_FALSE(scene.loads[1].follows);
}

TEST_F(SpatialScene, Signals) {
  ASSERT_EQ(scene.inputs.size(), 4u);
  EXPECT_EQ(scene.inputs[0].quantity, Quantity::acceleration);
  EXPECT_EQ(scene.inputs[1].quantity, Quantity::torque);
  EXPECT_EQ(scene.inputs[1].direction, Vector3d::UnitX());
  EXPECT_EQ(scene.inputs[2].element, "boom/1");
  EXPECT_EQ(scene.inputs[2].mode, 4);
  EXPECT_EQ(scene.inputs[3].quantity, Quantity::deformation_rate);
  EXPECT_EQ(scene.inputs[3].mode, 1);
  ASSERT_EQ(scene.outputs.size(), 5u);
  EXPECT_EQ(scene.outputs[0].quantity, Quantity::reaction);
  EXPECT_EQ(scene.outputs[1].quantity, Quantity::reaction_moment);
  EXPECT_EQ(scene.outputs[1].direction, Vector3d::UnitY());
  EXPECT_EQ(scene.outputs[2].quantity, Quantity::angular_velocity);
  EXPECT_EQ(scene.outputs[3].quantity, Quantity::deformation_acceleration);
  EXPECT_EQ(scene.outputs[3].mode, 2);
  EXPECT_EQ(scene.outputs[4].node, "boom/3");
}

TEST_F(PlanarScene, VectorsHaveTwoNumbers) {
  EXPECT_TRUE(scene.planar);
  EXPECT_EQ(scene.gravity, Vector3d(0, -9.81, 0));
  EXPECT_EQ(scene.operating_point, OperatingPoint::as_written);
  EXPECT_EQ(position(scene, "pin"), Vector3d(0.3, 0, 0));
  EXPECT_EQ(position(scene, "crank"), Vector3d::Zero());
  EXPECT_EQ(scene.loads[0].force, Vector3d(1, 2, 0));
  EXPECT_EQ(scene.loads[0].torque, Vector3d(0, 0, 3));
  EXPECT_TRUE(scene.outputs[1].direction.isApprox(Vector3d(0.6, 0.8, 0), 1e-15));  // rounding
}

TEST_F(PlanarScene, InertiaIsAboutZ) {
  EXPECT_TRUE(scene.masses[0].has_inertia);
  EXPECT_EQ(scene.masses[0].inertia, Matrix3d(Vector3d(0, 0, 0.3).asDiagonal()));
}

TEST_F(PlanarScene, ElementsHaveFewerDeformations) {
  EXPECT_EQ(element(scene, "motor").n_deformations, 1);
  EXPECT_FALSE(element(scene, "motor").rigid());
  EXPECT_EQ(element(scene, "arm").zero, std::vector<bool>(3, true));
  EXPECT_EQ(element(scene, "knee").stiffness, MatrixXd::Constant(1, 1, 4));
  EXPECT_EQ(element(scene, "knee").damping, MatrixXd::Constant(1, 1, 5));
  EXPECT_EQ(element(scene, "knee").preload, Eigen::VectorXd::Constant(1, 6));
  const SceneElement& link = element(scene, "link");
  EXPECT_EQ(link.n_deformations, 3);
  EXPECT_EQ(link.zero, std::vector<bool>(3, false));
  EXPECT_EQ(link.beam.EA, 1e6);
  EXPECT_EQ(link.beam.EI_z, 20);
  EXPECT_EQ(link.beam.EI_y, 0);
  EXPECT_EQ(link.beam.shear_y, 3e5);
  EXPECT_EQ(link.beam.mass_per_length, 0.4);
}

TEST_F(PlanarScene, MotionsAndDofs) {
  EXPECT_TRUE(scene.supports[0].rotation);
  EXPECT_FALSE(scene.supports[1].rotation);
  EXPECT_EQ(scene.prescribed[0].value, 0.1);
  EXPECT_EQ(scene.prescribed[0].acceleration, -1);
  EXPECT_TRUE(scene.prescribed[1].rotation);
  EXPECT_EQ(scene.prescribed[1].directions.size(), 1u);
  EXPECT_EQ(scene.dofs[0].mode, 2);
  EXPECT_EQ(scene.dofs[0].value, 1e-3);
  EXPECT_EQ(scene.dofs[0].rate, -2e-3);
  EXPECT_TRUE(scene.dofs[1].rotation);
  EXPECT_EQ(scene.dofs[1].node, "slider");
}

TEST_F(PlanarScene, RotationsAreAboutZ) {
  EXPECT_EQ(scene.inputs[0].direction, Vector3d::UnitZ());
  EXPECT_EQ(scene.outputs[0].direction, Vector3d::UnitZ());
}

TEST(SceneReader, LeavesTheDofsToTheModel) {
  const Scene scene =
      parse_scene("title: t\nnodes: {}\nmasses: []\nelements: {}\ndofs: auto\n", "");
  EXPECT_TRUE(scene.automatic_dofs);
  EXPECT_TRUE(scene.dofs.empty());
}

TEST(SceneReader, ReadsOlderScenesAsBefore) {
  const Scene scene = read_scene(STILLFRAME_SOURCE_DIR "/config/scenes/metrology_frame.yaml");
  EXPECT_FALSE(scene.planar);
  EXPECT_EQ(scene.gravity, Vector3d::Zero());
  EXPECT_EQ(scene.operating_point, OperatingPoint::equilibrium);
  EXPECT_EQ(scene.nodes.size(), 10u);
  EXPECT_EQ(scene.elements.size(), 9u);
  for (const SceneConstraint& motion : scene.prescribed) {
    EXPECT_EQ(motion.directions.size(), 3u);
    EXPECT_EQ(motion.value, 0);
    EXPECT_EQ(motion.rate, 0);
    EXPECT_EQ(motion.acceleration, 0);
  }
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(scene.dofs[i].mode, 1);
    EXPECT_EQ(element(scene, scene.dofs[i].element).stiffness, MatrixXd::Constant(1, 1, 3.95e6));
  }
}

/// What a divided beam weighs and how long it is does not depend on the number of parts.
TEST(SceneReader, PartsOfABeamAddUp) {
  for (const int n : {1, 2, 7, 30}) {
    std::string text = every_spatial_key;
    text.replace(text.find("divide: 4"), 9, "divide: " + std::to_string(n));
    // Names of parts that are no longer there.
    text = text.substr(0, text.find("masses:")) + "masses: []\n" +
           text.substr(text.find("elements:"), text.find("supports:") - text.find("elements:")) +
           "dofs: auto\n";
    const Scene scene = parse_scene(text, "crane.yaml");
    double length = 0;
    int parts = 0;
    for (const SceneElement& part : scene.elements) {
      if (!part.name.starts_with("boom")) continue;
      length += (position(scene, part.node_q) - position(scene, part.node_p)).norm();
      ++parts;
    }
    EXPECT_EQ(parts, n);
    EXPECT_NEAR(length, std::sqrt(9.25), 1e-14);  // 30 sums, each rounded in its last bit
  }
}

}  // namespace
}  // namespace stillframe::test
