#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "controller/law.hpp"
#include "core/numerics/two_pi.hpp"
#include "judge/loop_design.hpp"
#include "plant_sim/sensor_errors.hpp"
#include "tests/plant_sim/frame.hpp"

// The noise of the force sensors in the closed loop of the nonlinear plant against what the sampled
// loop says of it, number by number and in the mean square.
namespace stillframe {
namespace {

// N/sqrt(Hz): forces so small that the nonlinearity is below the integrator's tolerance.
constexpr ForceSensorErrors errors{.noise = 1e-8, .seed = 3};

const judge::LoopDesign& design() {
  static const judge::LoopDesign value = judge::make_loop_design(test::frame_file(), std::nullopt);
  return value;
}

struct Recorded {
  Eigen::MatrixXd frame, noise;  ///< six rows, a column a sample
};

/// A loop on a floor that stands still, with one sample of delay.
Recorded run(int n) {
  Scene scene = design().scene;
  scene.controller->force_limit_n.reset();
  const double filter = scene.instruments.sensor_filter_hz;
  const double T = design().sampled.sample_time;
  Plant plant(scene, test::table(Eigen::MatrixXd::Zero(6, n)));
  controller::Law law(controller::law_from_gains(design().gains));
  ForceSensorNoise noise(6, errors, T, filter);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(6), pending = force, sigma = force;
  Recorded out{Eigen::MatrixXd(6, n), Eigen::MatrixXd(6, n)};
  for (int k = 0; k < n; ++k) {
    if (k > 0) noise.next();
    const Reading& reading = plant.read();
    sigma = reading.sigma;
    noise.apply(sigma);
    out.noise.col(k) = sigma - reading.sigma;
    law.step(sigma, reading.applied_force, force);
    EXPECT_EQ(plant.advance(pending), "");
    pending = force;
    out.frame.col(k) = plant.read().frame_acceleration.head(6);
  }
  return out;
}

TEST(NoisePrediction, HoldsNumberByNumber) {
  const Recorded is = run(1000);
  const SampledLoop& loop = design().closed;
  Eigen::VectorXd xi = Eigen::VectorXd::Zero(loop.A.rows());
  double error = 0, size = 0;
  for (Eigen::Index k = 0; k < is.frame.cols(); ++k) {
    const Eigen::VectorXd predicted = loop.C * xi + loop.D_v * is.noise.col(k);
    xi = (loop.A * xi + loop.B_v * is.noise.col(k)).eval();
    error += (is.frame.col(k) - predicted).squaredNorm();
    size += predicted.squaredNorm();
  }
  // The scene's tolerance, 1e-5 of each sample.
  EXPECT_LT(std::sqrt(error / size), 1e-4);
}

TEST(NoisePrediction, HoldsInTheMeanSquare) {
  ASSERT_EQ(design().gains.delay_samples, 1);
  constexpr int n = 12'000, settling = 2'000;
  const Eigen::MatrixXd frame = run(n).frame.rightCols(n - settling);
  const double T = design().sampled.sample_time, seconds = (n - settling) * T;
  // White up to half the rate, each leg on its own: density S^2 times |N|^2 at every frequency, by
  // the trapezoidal rule, which is spectrally accurate around the circle.
  constexpr int lines = 20'000;
  const double df = 0.5 / T / lines;
  Eigen::VectorXd mean_square = Eigen::VectorXd::Zero(6), square = mean_square;
  for (int i = 0; i < lines; ++i) {
    const auto N = noise_transfer(design().closed, two_pi * (i + 0.5) * df);
    const Eigen::VectorXd density = errors.noise * errors.noise * N.rowwise().squaredNorm();
    mean_square += density * df;
    square += density.cwiseAbs2() * df;
  }
  for (Eigen::Index i = 0; i < 6; ++i) {
    // Over T seconds the mean square of Gaussian noise of density S(f) has the variance
    // integral of S^2 df / T.
    const double deviation = std::sqrt(square(i) / seconds);
    const double is = frame.row(i).squaredNorm() / static_cast<double>(frame.cols());
    std::cout << "rms " << std::sqrt(is) << " m/s^2, predicted " << std::sqrt(mean_square(i))
              << " +- " << 50 * deviation / mean_square(i) << " %\n";
    EXPECT_NEAR(is, mean_square(i), 4 * deviation);
    EXPECT_LT(deviation, 0.05 * mean_square(i));  // so that the bound says something
  }
}

}  // namespace
}  // namespace stillframe
