#include <gtest/gtest.h>

#include "plant_sim/floor_motion.hpp"
#include "tests/plant_sim/frame.hpp"

namespace stillframe {
namespace {

TEST(FloorMotion, IntegratesHeldAccelerationsExactly) {
  const Scene scene = test::frame_scene();
  const Model model = make_model(scene);
  const Eigen::MatrixXd a = test::noise(6, 50, 1);
  FloorMotion motion(test::table(a), scene, model);
  const double T = 1e-3;
  Eigen::VectorXd v = Eigen::VectorXd::Zero(6), x = v, q_r(model.n_r), q_r_dot(model.n_r), along(6);
  for (int k = 0; k < 50; ++k) {
    motion.take(k);
    motion.along_inputs(along);
    EXPECT_LT((along - a.col(k)).norm(), 1e-15);  // the directions of the inputs are unit vectors
    x += T * v + 0.5 * T * T * a.col(k);          // the double sum, written out
    v += T * a.col(k);
    motion.finish(T);
  }
  motion.floor_at(0.0, q_r, q_r_dot);
  for (Index i = 0; i < 6; ++i) {
    const auto& input = scene.inputs[static_cast<size_t>(i)];
    const Eigen::VectorXd pattern =
        model.prescribed_pattern(model.node_index(input.node), input.direction, input.place);
    EXPECT_NEAR(pattern.dot(q_r), x(i), 1e-15);  // rounding of sums of about 1e-3
    EXPECT_NEAR(pattern.dot(q_r_dot), v(i), 1e-15);
  }
}

TEST(FloorMotion, TranslationsMoveEveryFloorNodeAlike) {
  const Scene scene = test::frame_scene();
  const Model model = make_model(scene);
  FloorMotion motion(test::translations(Eigen::Vector3d(1, 2, 3)), scene, model);
  motion.take(0);
  for (const char* node : {"floor_1t", "floor_2v", "floor_3t"}) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto row = model.translation_row(model.node_index(node), Eigen::Vector3d::Unit(axis));
      EXPECT_DOUBLE_EQ(row.tail(model.n_r) * motion.floor_acceleration(), axis + 1.0);
    }
  }
}

}  // namespace
}  // namespace stillframe
