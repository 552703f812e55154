#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "core/errors/input_error.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "plant_sim/disturbances.hpp"

namespace stillframe {
namespace {

const std::string mass_on_a_leg = R"(
title: A mass on a leg, free along a skew direction
nodes:
  table: {position: [0, 0, 0]}
  mass: {position: [0.3, 0, 0.4]}
masses:
  - {node: mass, mass: 10}
elements:
  leg: {type: truss, nodes: [table, mass], stiffness: 4e5}
supports:
  - {nodes: [table], fix: [x, y]}
  - {nodes: [mass], fix: [y, [-4, 0, 3]]}
prescribed:
  - {nodes: [table], move: [z]}
dofs:
  - {element: leg}
)";

Scene scene_with(const std::string& force, const std::string& node = "mass",
                 const std::string& along = "x") {
  return parse_scene(mass_on_a_leg + "disturbances:\n  - {name: push, node: " + node +
                         ", along: " + along + ", force: {" + force + "}}\n",
                     "scene.yaml");
}

/// The force held over the first n samples.
Eigen::VectorXd values(const std::string& force, double T, int n) {
  const Scene scene = scene_with(force);
  const Model model = make_model(scene);
  Disturbances disturbances(scene, model, T);
  Eigen::VectorXd result(n);
  for (int k = 0; k < n; ++k) {
    disturbances.take(k);
    result(k) = disturbances.values()(0);
  }
  return result;
}

TEST(Disturbances, AreNoneWithoutTheBlock) {
  const Scene scene = parse_scene(mass_on_a_leg, "scene.yaml");
  const Model model = make_model(scene);
  Disturbances none(scene, model, 1e-3);
  none.take(5);
  EXPECT_EQ(none.forces().size(), 0);
}

TEST(Disturbances, DoTheWorkOfTheirForceOnAnyDisplacement) {
  const Scene scene = scene_with("step: {height: 7}", "mass", "[1, 2, 2]");
  const Model model = make_model(scene);
  Disturbances disturbances(scene, model, 1e-3);
  EXPECT_EQ(disturbances.forces().size(), model.n_x);
  disturbances.take(3);
  const Index mass = model.node_index("mass");
  for (Index i = 0; i < model.n_x; ++i) {
    const Eigen::VectorXd x = Eigen::VectorXd::Unit(model.n_x, i);
    Eigen::Vector3d u;
    for (int axis = 0; axis < 3; ++axis) {
      u(axis) = model.translation_row(mass, Eigen::Vector3d::Unit(axis)) * x;
    }
    EXPECT_NEAR(disturbances.forces().dot(x), 7 * u.dot(Eigen::Vector3d(1, 2, 2) / 3), 1e-14);
  }
  EXPECT_EQ(disturbances.forces(), disturbances.patterns() * disturbances.values());
}

TEST(Disturbances, TheImpulseOfAnImpactIsRightHoweverShort) {
  const double T = 1e-3;
  for (const double width : {0.05, 0.0031, 0.0002}) {
    const auto f =
        values("impact: {peak: 100, width_s: " + std::to_string(width) + ", at_s: 0.0123}", T, 100);
    // The integral of half a sine; means of samples of 100 N round by 1e-14.
    EXPECT_NEAR(f.sum() * T, 100 * 2 * width / std::numbers::pi, 1e-14);
    EXPECT_EQ(f(11), 0.0);
    EXPECT_GT(f(12), 0.0);
  }
}

TEST(Disturbances, AStepRisesSmoothlyOrAtOnce) {
  const auto f = values("step: {height: -3, rise_s: 0.01, at_s: 0.005}", 1e-3, 30);
  EXPECT_EQ(f(4), 0.0);
  EXPECT_NEAR(f.segment(5, 10).sum(), -3 * 5, 1e-13);  // its mean is half of its height
  EXPECT_NEAR(f(9) + f(10), -3, 1e-14);                // and it is symmetric
  EXPECT_NEAR(f(15), -3.0, 1e-13);
  const auto jump = values("step: {height: 2, at_s: 0.0055}", 1e-3, 10);
  EXPECT_EQ(jump(4), 0.0);
  EXPECT_NEAR(jump(5), 1.0, 1e-12);  // half of the sample
  EXPECT_EQ(jump(6), 2.0);
  EXPECT_EQ(values("step: {height: 2}", 1e-3, 1)(0), 2.0);
}

TEST(Disturbances, ASineIsHeldAtItsMeanAndKeepsItsPhaseForHours) {
  const Scene scene = scene_with("sine: {amplitude: 2, frequency_hz: 31.7, at_s: 0.0025}");
  const Model model = make_model(scene);
  const double T = 1e-3;
  Disturbances disturbances(scene, model, T);
  for (const std::int64_t k : {3, 10, 36000001}) {
    disturbances.take(k);
    // The mean of the sine, the angle taken in long double.
    const long double w = 2 * std::numbers::pi_v<long double> * 31.7L;
    const long double t = static_cast<long double>(k) * 1e-3L - 0.0025L;
    const long double mean = 2 * (std::cos(w * t) - std::cos(w * (t + 1e-3L))) / (w * 1e-3L);
    // After ten hours t = 3.6e4 s rounds by 4e-12 s, an angle of 1e-9.
    EXPECT_NEAR(disturbances.values()(0), static_cast<double>(mean), k < 100 ? 1e-12 : 4e-9) << k;
  }
  disturbances.take(1);
  EXPECT_EQ(disturbances.values()(0), 0.0);
}

TEST(Disturbances, ASweepGoesFromOneFrequencyToTheOther) {
  const auto f = values(
      "sine_sweep: {amplitude: 5, from_hz: 2, to_hz: 50, sweep_s: 20, spacing: linear, at_s: 1}",
      1e-3, 22000);
  EXPECT_TRUE(f.head(1000).isZero(0));
  EXPECT_TRUE(f.tail(999).isZero(0));
  for (const int k : {5000, 10007, 17003}) {
    const double t = (k + 0.5) * 1e-3 - 1;
    const double phase = 2 * std::numbers::pi * (2 * t + 48 * t * t / 40);
    EXPECT_NEAR(f(k), 5 * std::sin(phase), 1e-9) << k;
  }
}

TEST(Disturbances, NoiseHasTheDensityAsked) {
  const int n = 10000;
  const auto f =
      values("noise: {psd: [[1, 0.01], [100, 0.0001]], period_s: 10, at_s: 1}", 1e-3, 1000 + 2 * n);
  EXPECT_TRUE(f.head(1000).isZero(0));
  EXPECT_EQ(f.segment(1000, n), f.segment(1000 + n, n));
  for (const int b : {10, 100, 999}) {
    std::complex<double> sum = 0;
    for (int k = 0; k < n; ++k) {
      const double turns = static_cast<double>(static_cast<std::int64_t>(b) * k % n) / n;
      sum += f(1000 + k) * std::polar(1.0, -2 * std::numbers::pi * turns);
    }
    const double density = 0.01 / (b / 10.0);  // a straight line of slope -1
    EXPECT_NEAR(2 * std::abs(sum) / n, std::sqrt(2 * density / 10.0), 1e-12) << b;
  }
}

TEST(Disturbances, ARecordingOfForcesIsResampled) {
  const auto csv = std::filesystem::path(::testing::TempDir()) / "stillframe_force.csv";
  {
    std::ofstream file(csv);
    file << "# fs_hz=512 n=3000 units=N\nstage\n";
    for (int k = 0; k < 3000; ++k)
      file << 4 * std::sin(2 * std::numbers::pi * 11.3 * k / 512) << "\n";
  }
  const std::string block =
      "recording: {file: '" + csv.string() + "', column: stage, scale: 0.5, at_s: 1}";
  const double T = 3.0 / 1000;
  const auto f = values(block, T, 2400);
  EXPECT_TRUE(f.head(333).isZero(0));  // at_s is sample 333
  // Away from the tapers of 1 s it is the sine: their spill at the Nyquist rate, 155 Hz away, is
  // below 1e-7 of it, and six digits stand in the file.
  for (int k = 333 + 700; k < 333 + 1200; ++k) {
    const double t = (k - 333) * T;
    EXPECT_NEAR(f(k), 2 * std::sin(2 * std::numbers::pi * 11.3 * t), 1e-5) << k;
  }
  EXPECT_EQ(f(2399), 0.0);
  EXPECT_THROW(values("recording: {file: '" + csv.string() + "', column: other}", T, 1),
               InputError);
  EXPECT_THROW(values("recording: {file: '" + csv.string() + "', column: stage, start_s: 4}", T, 1),
               InputError);
  EXPECT_THROW(values("recording: {file: missing.csv, column: stage}", T, 1), InputError);
  std::filesystem::remove(csv);
}

TEST(Disturbances, WhatCannotBeIsRefused) {
  EXPECT_THROW(values("sine: {amplitude: 1, frequency_hz: 500}", 1e-3, 1), InputError);
  EXPECT_THROW(values("sine_sweep: {amplitude: 1, from_hz: 1, to_hz: 600, sweep_s: 1}", 1e-3, 1),
               InputError);
  EXPECT_THROW(values("noise: {psd: [[600, 1], [700, 1]]}", 1e-3, 1), InputError);
  EXPECT_THROW(values("noise: {psd: [[1, 1], [2, 1]], period_s: 1e5}", 1e-3, 1), InputError);
  EXPECT_THROW(scene_with("sine: {amplitude: 1, frequency_hz: 1}, step: {height: 1}"), InputError);
  EXPECT_THROW(scene_with("noise: {psd: [[2, 1], [1, 1]]}"), InputError);
  EXPECT_THROW(scene_with("step: {height: 1}", "nowhere"), InputError);
  // Fixed along x, prescribed along z: a force there does nothing.
  for (const char* along : {"x", "z"}) {
    const Scene scene = scene_with("step: {height: 1}", "table", along);
    const Model model = make_model(scene);
    EXPECT_THROW(Disturbances(scene, model, 1e-3), InputError) << along;
  }
}

}  // namespace
}  // namespace stillframe
