#include <gtest/gtest.h>

#include "bench/simbody/plant_run.hpp"
#include "core/mechanics/scene/scene_reader.hpp"

// The nonlinear plant against Simbody, another program with other coordinates (joint coordinates
// and quaternions), other equations (recursive) and other integrators.
namespace stillframe::simbody {
namespace {

const std::filesystem::path top = STILLFRAME_SOURCE_DIR;

/// Largest difference at any sample against the largest acceleration.
double worst(const Run& a, const Run& b) {
  return (a.accelerations - b.accelerations).cwiseAbs().maxCoeff() /
         b.accelerations.cwiseAbs().maxCoeff();
}

TEST(Simbody, AgreesOnTheFrame) {
  // Simbody takes each elongation as a difference of lengths: 0.15 m * 2e-16 in about 2e-5 m. A
  // mean acceleration is a difference of velocities over 1 ms, which multiplies what the
  // integrators leave (1e-14 of a length of 1 m) by 1e2.
  const Scene scene = read_scene(top / "config/scenes/metrology_frame.yaml");
  const Eigen::MatrixXd floor = sines(6, 200, 1e-3, 1, 1, 100);
  const auto other = simbody_run(body_on_springs(scene), floor, Method::runge_kutta_merson, 1e-14);
  const auto ours = plant_run(scene, floor, 1e-11);
  const double difference = worst(ours, other);
  RecordProperty("difference", std::to_string(difference));
  EXPECT_LT(difference, 1e-8);
  // It is the nonlinear equations that are compared: the two outputs of one mount differ from what
  // symmetry of a linear frame would make of opposite floors.
  const auto opposite =
      simbody_run(body_on_springs(scene), -floor, Method::runge_kutta_merson, 1e-14);
  auto mirrored = opposite;
  mirrored.accelerations *= -1;
  EXPECT_GT(worst(other, mirrored), 1e2 * difference);
}

TEST(Simbody, AgreesOnADoublePendulumThatSwingsFar) {
  const Scene scene = read_scene(top / "bench/simbody/pendulum.yaml");
  const Eigen::MatrixXd floor = sines(3, 100, 1 / scene.controller->sample_rate_hz, 10, 0.5, 5);
  const auto other = simbody_run(link_chain(scene), floor, Method::runge_kutta_merson, 1e-11);
  const auto ours = plant_run(scene, floor, 1e-11);
  // Both integrators leave 1e-11 a step, over 100 samples of 20 ms; the motion is not chaotic for
  // so short a time, but multiplies errors by up to 1e2.
  EXPECT_LT(worst(ours, other), 1e-7);
  // No small motion has accelerations of twice gravity here: the base makes less than one.
  EXPECT_GT(ours.accelerations.cwiseAbs().maxCoeff(), 20);
}

}  // namespace
}  // namespace stillframe::simbody
