#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "core/mechanics/scene/scene_reader.hpp"
#include "judge/shapes.hpp"

namespace stillframe::judge {
namespace {

page::ModeShapes shapes_of(const std::string& scene_name) {
  const Scene scene =
      read_scene(std::string(STILLFRAME_SOURCE_DIR) + "/config/scenes/" + scene_name);
  return mode_shapes(scene, make_model(scene)).value();
}

/// Frequencies of the deck, to their printed digit.
TEST(Shapes, FrameHasTheSixPicturesOfTheDeck) {
  const page::ModeShapes shapes = shapes_of("metrology_frame.yaml");
  const double published_hz[] = {13.9, 13.9, 20.0, 31.3, 31.3, 49.0};
  ASSERT_EQ(shapes.modes.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(shapes.modes[i].frequency_hz, published_hz[i], 0.05);
    EXPECT_FALSE(shapes.modes[i].damping_ratio) << "the legs have no damping";
  }
}

TEST(Shapes, FloorNodesStandStillAndBearNoMass) {
  const page::ModeShapes shapes = shapes_of("metrology_frame.yaml");
  int n_floor = 0;
  for (std::size_t i = 0; i < shapes.nodes.size(); ++i) {
    const page::ShapeNode& node = shapes.nodes[i];
    EXPECT_EQ(node.floor, node.name.starts_with("floor_")) << node.name;
    EXPECT_EQ(node.mass, node.name == "lens" ? 750 : 0);
    n_floor += node.floor;
    for (const page::ModeShape& mode : shapes.modes) {
      const double size = mode.displacement.row(static_cast<Eigen::Index>(i)).norm();
      if (node.floor) {
        EXPECT_EQ(size, 0) << node.name;
      }
    }
  }
  EXPECT_EQ(n_floor, 6);
}

/// A rigid frame moves as one: u_i = t + r x p_i for one t and r.
TEST(Shapes, RigidFrameMovesAsOneBody) {
  const page::ModeShapes shapes = shapes_of("metrology_frame.yaml");
  for (const page::ModeShape& mode : shapes.modes) {
    Eigen::MatrixXd A(0, 6);
    Eigen::VectorXd u(0);
    for (std::size_t i = 0; i < shapes.nodes.size(); ++i) {
      if (shapes.nodes[i].floor) continue;
      const Eigen::Vector3d p = shapes.nodes[i].position;
      A.conservativeResize(A.rows() + 3, 6);
      u.conservativeResize(u.size() + 3);
      Eigen::Matrix3d across;
      across << 0, p.z(), -p.y(), -p.z(), 0, p.x(), p.y(), -p.x(), 0;
      A.bottomRows(3) << Eigen::Matrix3d::Identity(), across;
      u.tail(3) = mode.displacement.row(static_cast<Eigen::Index>(i)).transpose();
    }
    ASSERT_EQ(u.size(), 12);
    const Eigen::VectorXd motion = A.colPivHouseholderQr().solve(u);
    // Rounding of a shape whose entries are of order 0.04.
    EXPECT_LT((A * motion - u).norm(), 1e-12 * u.norm());
    EXPECT_GT(u.norm(), 0);
  }
}

/// Half the kinetic energy of a mass-normalised mode with unit rate is 1/2: m |t|^2 + r^T I r = 1
/// with the lens at the centre of mass; vertical motion of the frame alone is mode 3.
TEST(Shapes, VerticalModeIsMassNormalised) {
  const page::ModeShapes shapes = shapes_of("metrology_frame.yaml");
  const Eigen::RowVector3d lens = shapes.modes[2].displacement.row(0);
  EXPECT_NEAR(std::abs(lens.z()), 1 / std::sqrt(750.0), 1e-9);  // coupling is zero by symmetry
  EXPECT_NEAR(lens.head(2).norm(), 0, 1e-9);
}

TEST(Shapes, ElementsJoinTheNodesOfTheScene) {
  const page::ModeShapes shapes = shapes_of("metrology_frame.yaml");
  ASSERT_EQ(shapes.elements.size(), 9u);
  EXPECT_EQ(shapes.elements[0].kind, page::ShapeKind::rigid);
  EXPECT_EQ(shapes.nodes[shapes.elements[0].node_p].name, "lens");
  EXPECT_EQ(shapes.elements[3].kind, page::ShapeKind::truss);
  EXPECT_EQ(shapes.nodes[shapes.elements[3].node_p].name, "floor_1t");
  EXPECT_EQ(shapes.nodes[shapes.elements[3].node_q].name, "mount_1");
}

TEST(Shapes, SceneInMotionHasNone) {
  const Scene scene =
      read_scene(std::string(STILLFRAME_SOURCE_DIR) + "/config/scenes/spinning_arm.yaml");
  EXPECT_FALSE(mode_shapes(scene, make_model(scene)));
}

/// The damped cart: zeta = c / (2 sqrt(k m)), omega = sqrt(k / m).
TEST(Shapes, DampedCartHasItsRatio) {
  const page::ModeShapes shapes = shapes_of("cart.yaml");
  ASSERT_EQ(shapes.modes.size(), 1u);
  EXPECT_NEAR(shapes.modes[0].frequency_hz, std::sqrt(800.0 / 2) / (2 * M_PI), 1e-12);
  ASSERT_TRUE(shapes.modes[0].damping_ratio);
  EXPECT_NEAR(*shapes.modes[0].damping_ratio, 4 / (2 * std::sqrt(800.0 * 2)), 1e-12);
}

}  // namespace
}  // namespace stillframe::judge
