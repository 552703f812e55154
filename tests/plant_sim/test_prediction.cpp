#include <gtest/gtest.h>

#include "controller/law.hpp"
#include "judge/loop_design.hpp"
#include "tests/plant_sim/frame.hpp"

// Plant and law in one program against the exact linear sampled-data system, sample by sample. What
// remains between them is nonlinearity, which shrinks with the amplitude, and integrator tolerance,
// which shrinks with the tolerance (THEORY section 5); both are shown to shrink.
namespace stillframe {
namespace {

/// Relative difference between the nonlinear closed loop and the prediction over half a second of
/// noise.
double difference(const judge::LoopDesign& design, double amplitude, double tolerance, int delay,
                  PlantMethod method = PlantMethod::automatic) {
  Scene scene = design.scene;
  scene.simulation.method = method;
  scene.simulation.relative_tolerance = tolerance;
  scene.controller->force_limit_n.reset();  // saturation is no part of the prediction
  const int n = 500;
  const Eigen::MatrixXd w = amplitude * test::noise(6, n, 3);
  Plant plant(scene, test::table(w));
  controller::Gains gains = design.gains;
  gains.lead_samples = delay + 0.5;  // as fits the delay; the scene's is for one sample
  const DiscreteLaw matrices = controller::law_from_gains(gains);
  controller::Law law(matrices);
  SampledPlant sampled = design.sampled;
  sampled.whole_delay.setConstant(delay);
  const SampledLoop loop = close_loop(sampled, matrices);
  Eigen::VectorXd xi = Eigen::VectorXd::Zero(loop.A.rows()), force = Eigen::VectorXd::Zero(6),
                  pending = force;
  double error = 0, size = 0;
  for (int k = 0; k < n; ++k) {
    const Reading& reading = plant.read();
    law.step(reading.sigma, reading.applied_force, force);
    EXPECT_EQ(plant.advance(delay == 0 ? force : pending), "");
    pending = force;
    const Eigen::VectorXd predicted = loop.C * xi + loop.D * w.col(k);
    xi = (loop.A * xi + loop.B * w.col(k)).eval();
    error += (plant.read().frame_acceleration.head(6) - predicted).squaredNorm();
    size += predicted.squaredNorm();
  }
  return std::sqrt(error / size);
}

class Prediction : public testing::TestWithParam<int> {
 protected:
  static const judge::LoopDesign& design() {
    static const judge::LoopDesign value =
        judge::make_loop_design(test::frame_file(), std::nullopt);
    return value;
  }
};

TEST_P(Prediction, NonlinearityShrinksWithTheAmplitude) {
  // The first neglected term of the geometry is of second order in the motion, so relative to the
  // motion it is proportional to the amplitude. 1 m/s^2 of noise moves the floor by some 0.1 mm.
  const double large = difference(design(), 1.0, 1e-13, GetParam());
  const double small = difference(design(), 1e-2, 1e-13, GetParam());
  std::cout << "delay " << GetParam() << ": nonlinear minus linear " << large << " at 1 m/s^2, "
            << small << " at 0.01 m/s^2\n";
  EXPECT_NEAR(small / large, 1e-2, 2e-3);
}

TEST_P(Prediction, ToleranceIsWhatRemains) {
  // At 1e-9 m/s^2 the nonlinearity is some 3e-11 of the motion (the test above).
  const auto error = [](double tolerance, PlantMethod method) {
    return difference(design(), 1e-9, tolerance, GetParam(), method);
  };
  const double coarse = error(1e-5, PlantMethod::dormand_prince);
  const double fine = error(1e-9, PlantMethod::dormand_prince);
  std::cout << "delay " << GetParam() << ": " << coarse << " at tolerance 1e-5, " << fine
            << " at 1e-9\n";
  EXPECT_LT(coarse, 1e-4);  // 0.001 dB
  EXPECT_LT(fine, 1e-2 * coarse);
  // The default method has nothing to err by where motion is linear.
  EXPECT_LT(error(1e-5, PlantMethod::automatic), 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Delay, Prediction, testing::Values(0, 1));

}  // namespace
}  // namespace stillframe
