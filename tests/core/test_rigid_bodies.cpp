#include <gtest/gtest.h>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/rigid_bodies.hpp"
#include "tests/core/element_cases.hpp"
#include "tests/core/scenes.hpp"

// A scene with one node for each rigid body moves as the scene with all its rigid beams.
namespace stillframe::test {
namespace {

TEST(MergedBodies, OfTheFrameHaveSevenCoordinates) {
  const MergedScene merged = merge_rigid_bodies(frame_scene());
  EXPECT_EQ(merged.carried.size(), 3u);
  EXPECT_EQ(merged.carried.at("mount_2").body, "lens");
  EXPECT_TRUE(merged.carried.at("mount_1").arm.isApprox(Eigen::Vector3d(0.6, 0, -0.1)));
  const Model model = make_model(merged.scene);
  EXPECT_EQ(model.n_c, 7);
  EXPECT_EQ(make_model(frame_scene()).n_c, 28);
}

TEST(MergedBodies, KeepWhatIsHeldMovedLoadedOrAskedFor) {
  Scene scene = frame_scene();
  scene.loads.push_back({.node = "mount_1", .place = "", .force = {0, 0, 1}});
  EXPECT_FALSE(merge_rigid_bodies(scene).carried.contains("mount_1"));
  EXPECT_FALSE(merge_rigid_bodies(frame_scene(), {"mount_3"}).carried.contains("mount_3"));
  EXPECT_TRUE(merge_rigid_bodies(mechanism()).carried.empty());
}

TEST(MergedBodies, AccelerateAsTheWholeScene) {
  // Any state, far from the undeformed one, with forces in the legs and a moving floor.
  const Scene scene = frame_scene();
  const Model whole = make_model(scene), merged = make_model(merge_rigid_bodies(scene).scene);
  Random random(3);
  for (int k = 0; k < 10; ++k) {
    Data a(whole), b(merged);
    MotionState state(whole);
    state.q_d = 0.01 * random.vector(6);
    state.q_d_dot = random.vector(6);
    state.q_r = 0.01 * random.vector(18);
    state.q_r_dot = random.vector(18);
    state.q_r_ddot = random.vector(18);
    VectorXd sigma_whole = VectorXd::Zero(whole.n_e), sigma_merged = VectorXd::Zero(merged.n_e);
    for (const SceneElement& element : scene.elements) {
      if (element.kind != SceneElement::Kind::truss) continue;
      const double force = 100 * random.vector(1)(0);
      sigma_whole(whole.deformation_row(element.name)) = force;
      sigma_merged(merged.deformation_row(element.name)) = force;
    }
    VectorXd q_whole(6), q_merged(6);
    ASSERT_EQ(accelerations(whole, a, state, sigma_whole, q_whole), DynamicsStatus::ok);
    ASSERT_EQ(accelerations(merged, b, state, sigma_merged, q_merged), DynamicsStatus::ok);
    // Both are exact; 28 and 7 unknowns round differently.
    EXPECT_LT((q_whole - q_merged).norm(), 1e-11 * q_whole.norm());
    EXPECT_LT((a.x.tail(18) - b.x.tail(18)).norm(), 1e-15);
    EXPECT_NEAR(kinetic_energy(whole, a), kinetic_energy(merged, b),
                1e-11 * kinetic_energy(whole, a));
  }
}

TEST(MergedBodies, FollowAChainOfRigidBeamsToTheBody) {
  Scene scene = frame_scene();
  // A further beam from mount_1 to a new node, to which leg_1v goes instead.
  SceneNode tip = scene.nodes[1];
  ASSERT_EQ(tip.name, "mount_1");
  tip.name = "tip";
  tip.position = {0.7, 0.1, -0.05};
  scene.nodes.push_back(tip);
  SceneElement beam = scene.elements[0];
  ASSERT_EQ(beam.name, "arm_1");
  beam.name = "finger";
  beam.node_p = "tip";
  beam.node_q = "mount_1";
  scene.elements.push_back(beam);
  for (SceneElement& element : scene.elements) {
    if (element.name == "leg_1v") element.node_q = "tip";
  }
  const MergedScene merged = merge_rigid_bodies(scene);
  EXPECT_EQ(merged.carried.at("tip").body, "lens");
  EXPECT_TRUE(merged.carried.at("tip").arm.isApprox(tip.position));
  const auto frequencies = [](const Scene& of) {
    const Model model = make_model(of);
    return modes(linearise(model, {}, {})).natural_frequencies_hz;
  };
  // 1e-12: rounding of eigenvalues of a well conditioned pencil.
  EXPECT_TRUE(frequencies(merged.scene).isApprox(frequencies(scene), 1e-12));
}

}  // namespace
}  // namespace stillframe::test
