#include <gtest/gtest.h>

#include "bench/large_motion/describe.hpp"
#include "bench/large_motion/our_runs.hpp"
#include "core/mechanics/scene/scene_reader.hpp"

// The nonlinear plant against Simbody, another program with other coordinates (joint coordinates
// and quaternions), other equations (recursive) and other integrators. Simbody's library holds an
// older SUNDIALS under the same names, which would be taken for ours: in this program only the
// methods that are our own can run.
namespace stillframe::race {
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
  const Mechanism frame = mechanism_of(scene);
  const Eigen::MatrixXd floor = sines(6, 200, 1e-3, 1, 1, 100);
  const auto other = simbody_run(frame, floor, "Merson", 1e-14);
  const auto ours = our_run(scene, floor, PlantMethod::exponential, 1e-11);
  const double difference = worst(ours, other);
  RecordProperty("difference", std::to_string(difference));
  EXPECT_LT(difference, 1e-8);
  // It is the nonlinear equations that are compared: the two outputs of one mount differ from what
  // symmetry of a linear frame would make of opposite floors.
  auto mirrored = simbody_run(frame, -floor, "Merson", 1e-14);
  mirrored.accelerations *= -1;
  EXPECT_GT(worst(other, mirrored), 1e2 * difference);
}

/// Scenes of rigid bodies that swing far, on a shaken base.
class LargeMotion : public testing::TestWithParam<const char*> {};

TEST_P(LargeMotion, AgreesWithSimbody) {
  const Scene scene = read_scene(top / "bench/large_motion" / (std::string(GetParam()) + ".yaml"));
  const auto n_inputs = static_cast<Eigen::Index>(scene.inputs.size());
  const Eigen::MatrixXd floor =
      sines(n_inputs, 100, 1 / scene.controller->sample_rate_hz, 3, 0.5, 5);
  const auto other = simbody_run(mechanism_of(scene), floor, "Merson", 1e-11);
  const auto ours = our_run(scene, floor, PlantMethod::nodal, 1e-11);
  // Both integrators leave 1e-11 a step, over 100 samples of 20 ms; the motion is not chaotic for
  // so short a time, but multiplies errors by up to 1e2. Simbody keeps a guide to 1e-11 m, which
  // over a sample is 1e-9 m/s and 5e-8 m/s^2.
  EXPECT_LT(worst(ours, other), 1e-7);
  // No small motion: velocities of metres a second.
  EXPECT_GT(ours.last_velocities(1).cwiseAbs().maxCoeff(), 20) << ours.last_velocities(1);
}
INSTANTIATE_TEST_SUITE_P(Scenes, LargeMotion,
                         testing::Values("pendulum", "boom", "slider_crank", "mast"));

}  // namespace
}  // namespace stillframe::race
