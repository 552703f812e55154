#include <gtest/gtest.h>

#include <cmath>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "plant_sim/integrator.hpp"
#include "tests/plant_sim/frame.hpp"

namespace stillframe {
namespace {

TEST(Plant, FirstReadingIsRest) {
  const Scene scene = test::frame_scene();
  Plant plant(scene, test::table(Eigen::MatrixXd::Zero(6, 10)));
  const Reading& reading = plant.read();
  EXPECT_EQ(reading.sigma.norm() + reading.applied_force.norm() + reading.frame_acceleration.norm(),
            0.0);
  EXPECT_EQ(reading.frame_acceleration.size(), 12);
}

TEST(Plant, ConstantLegForceFirstMovesTheFrameByNewtonsLaw) {
  // Equal tension in the three vertical legs pulls the frame down; the springs have not moved yet,
  // so the mean acceleration over the first sample is -3 F / m up to omega^2 T^2 / 6 of the
  // vertical mode (20 Hz: 2.6e-3).
  const Scene scene = test::frame_scene();
  Plant plant(scene, test::table(Eigen::MatrixXd::Zero(6, 10)));
  Eigen::VectorXd force(6);
  force << 0, 2, 0, 2, 0, 2;
  ASSERT_EQ(plant.advance(force), "");
  const Reading& reading = plant.read();
  EXPECT_EQ(reading.applied_force, force);
  EXPECT_NEAR(reading.frame_acceleration(11), -6.0 / 750, 3e-3 * 6.0 / 750);
  EXPECT_NEAR(reading.frame_acceleration(9), 0,
              1e-9 * 6.0 / 750);  // symmetry, to rounding of the geometry
}

TEST(Plant, ForceLimitIsAppliedAndMeasured) {
  Scene scene = test::frame_scene();
  scene.controller->force_limit_n = 0.5;
  Plant plant(scene, test::table(Eigen::MatrixXd::Zero(6, 10)));
  Eigen::VectorXd force(6);
  force << 0.1, 2, -3, 0, 0, 0;
  ASSERT_EQ(plant.advance(force), "");
  Eigen::VectorXd expected(6);
  expected << 0.1, 0.5, -0.5, 0, 0, 0;
  EXPECT_EQ(plant.read().applied_force, expected);
}

TEST(Plant, SaysWhenAndWhyItCannotGoOn) {
  // A floor node that is gone within a sample: a leg of a kilometre can still be followed, one of
  // so many has no length that a double could tell from another.
  Scene scene = test::frame_scene();
  Eigen::MatrixXd huge = Eigen::MatrixXd::Zero(6, 10);
  huge(0, 3) = 1e20;
  const double limit = scene.controller->force_limit_n.value();
  for (const PlantMethod method : {PlantMethod::automatic, PlantMethod::exponential,
                                   PlantMethod::nodal, PlantMethod::dormand_prince}) {
    scene.simulation.method = method;
    Plant plant(scene, test::table(huge));
    std::string reason;
    for (int k = 0; k < 10 && reason.empty(); ++k) {
      reason = plant.advance(Eigen::VectorXd::Constant(6, k < 2 ? limit : 0.9 * limit));
    }
    EXPECT_NE(reason.find("plant at t = 0.00"), std::string::npos) << reason;
    EXPECT_NE(reason.find(" m from the operating point, "), std::string::npos) << reason;
    EXPECT_NE(reason.find("e(leg_"), std::string::npos) << reason;
    EXPECT_NE(reason.find(" m/s, and 2 of "), std::string::npos) << reason;
  }
}

TEST(Plant, TheSameInputsGiveTheSameBits) {
  const Scene scene = test::frame_scene();
  const Eigen::MatrixXd a = 1e-3 * test::noise(6, 200, 2);
  Plant first(scene, test::table(a)), second(scene, test::table(a));
  for (int k = 0; k < 200; ++k) {
    const Eigen::VectorXd force = test::noise(6, 1, static_cast<unsigned>(k));
    ASSERT_EQ(first.advance(force), "");
    ASSERT_EQ(second.advance(force), "");
    ASSERT_EQ(first.read().frame_acceleration, second.read().frame_acceleration) << k;
    ASSERT_EQ(first.read().sigma, second.read().sigma) << k;
  }
}

/// The frame integrated with held forces and nothing else, written out.
struct BareFrame {
  const Model& model;
  FloorMotion floor;
  Data data{model};
  MotionState state{model};
  Eigen::VectorXd y = Eigen::VectorXd::Zero(2 * model.n_d), rate = y,
                  sigma_a = Eigen::VectorXd::Zero(model.n_e),
                  q_ddot = Eigen::VectorXd::Zero(model.n_d);
  Integrator integrator;

  BareFrame(const Scene& scene, const Model& frame, const Eigen::MatrixXd& a)
      : model(frame),
        floor(test::table(a), scene, frame),
        integrator(
            frame.n_d,
            [this](double t, const Eigen::Ref<const Eigen::VectorXd>& at,
                   Eigen::Ref<Eigen::VectorXd> dy_dt) { return derivative(t, at, dy_dt); },
            // What a run asks of its steps: a share, and of each entry of y.
            0.03 * scene.simulation.relative_tolerance / std::sqrt(2.0 * double(frame.n_d))) {
    data.x = solve_equilibrium(model).motion.x;
  }
  bool derivative(double t, const Eigen::Ref<const Eigen::VectorXd>& at,
                  Eigen::Ref<Eigen::VectorXd> dy_dt) {
    state.q_d = at.head(model.n_d);
    state.q_d_dot = at.tail(model.n_d);
    floor.floor_at(t, state.q_r, state.q_r_dot);
    state.q_r_ddot = floor.floor_acceleration();
    const bool sound = accelerations(model, data, state, sigma_a, q_ddot) == DynamicsStatus::ok;
    dy_dt << state.q_d_dot, q_ddot;
    return sound;
  }
  /// As a run does it: errors are held against the larger acceleration of the part's two ends.
  void advance(std::int64_t k, double sample_time) {
    const double before = q_ddot.lpNorm<Eigen::Infinity>();
    floor.take(k);
    ASSERT_TRUE(derivative(sample_time, y, rate));
    const double acceleration = std::max(before, q_ddot.lpNorm<Eigen::Infinity>());
    ASSERT_EQ(integrator.advance(y, sample_time, acceleration, sample_time),
              Integrator::Status::ok);
    ASSERT_TRUE(derivative(sample_time, y, rate));
    floor.finish(sample_time);
  }
};

TEST(Plant, IdealInstrumentsAddNothing) {
  // The same steps, so only rounding is between the two (compilers may contract one and not the
  // other); at a tolerance that takes several steps a sample, other steps would differ by 1e-10.
  Scene scene = test::frame_scene();
  scene.simulation.relative_tolerance = 1e-9;
  scene.simulation.method = PlantMethod::dormand_prince;
  const Scene merged = merge_rigid_bodies(scene).scene;
  const Model model = make_model(merged);
  const Eigen::MatrixXd a = 1e-3 * test::noise(6, 200, 2);
  Plant plant(scene, test::table(a));
  BareFrame bare(merged, model, a);
  for (int k = 0; k < 200; ++k) {
    const Eigen::VectorXd force = test::noise(6, 1, static_cast<unsigned>(k));
    for (Index leg = 0; leg < 6; ++leg) {
      bare.sigma_a(model.deformation_row(scene.controller->legs[static_cast<size_t>(leg)])) =
          force(leg);
    }
    ASSERT_EQ(plant.advance(force), "");
    bare.advance(k, 1 / scene.controller->sample_rate_hz);
    const Reading& reading = plant.read();
    EXPECT_EQ(reading.applied_force, force);
    for (Index leg = 0; leg < 6; ++leg) {
      const Index row = model.deformation_row(scene.controller->legs[static_cast<size_t>(leg)]);
      ASSERT_NEAR(reading.sigma(leg), bare.data.sigma(row), 1e-12) << k;  // of about 1 N
    }
    // The run counts the two looks as well that it takes at the acceleration of each part.
    ASSERT_EQ(plant.evaluations(), bare.integrator.evaluations() + 2 * (k + 1));
  }
}

// Under its weight the frame rests on forces that balance to rounding only, and stays there.
TEST(PlantUnderGravity, RestsOnAFloorThatRests) {
  const Scene scene = read_scene(
      std::filesystem::path(STILLFRAME_SOURCE_DIR "/config/scenes/frame_under_gravity.yaml"), {});
  Plant plant(scene, test::table(Eigen::MatrixXd::Zero(6, 20)));
  for (int k = 0; k < 20; ++k) {
    ASSERT_EQ(plant.advance(Eigen::VectorXd::Zero(6)), "") << k;
    // Rounding of 2.5 kN in each leg.
    EXPECT_LT(worst_of(plant.read().sigma), 1e-9) << k;
  }
}

}  // namespace
}  // namespace stillframe
