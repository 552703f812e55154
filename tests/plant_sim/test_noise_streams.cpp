#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "plant_sim/disturbances.hpp"
#include "plant_sim/floor/floor_block.hpp"

// Sources of noise with one number under `seed` are independent of each other.
namespace stillframe {
namespace {

constexpr int n = 4000;
constexpr double rate = 200;

const std::string scene_text = R"(
title: A mass on a leg with two noises
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
disturbances:
  - {name: fan, node: mass, along: x, force: {noise: {psd: [[1, 1], [50, 1]], period_s: 20}}}
  - {name: pump, node: mass, along: x, force: {noise: {psd: [[1, 1], [50, 1]], period_s: 20}}}
)";

/// The courses of a floor's channels, samples x channels.
Eigen::MatrixXd floor_courses(const std::string& block) {
  const auto floor = floor::make_floor_source(
      floor::read_floor_block(YamlReader::from_text(block, "floor.yaml"), rate, 1));
  Eigen::MatrixXd courses(n, floor->channels());
  Eigen::VectorXd sample(floor->channels());
  for (Eigen::Index k = 0; k < n; ++k) {
    floor->sample(k, sample);
    courses.row(k) = sample.transpose();
  }
  return courses;
}

/// Largest magnitude of a correlation among columns (each of mean zero) that move at all.
double largest_correlation(const Eigen::MatrixXd& courses) {
  double largest = 0;
  for (Eigen::Index i = 0; i < courses.cols(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const double size = courses.col(i).norm() * courses.col(j).norm();
      if (size != 0)
        largest = worst_of(largest, std::abs(courses.col(i).dot(courses.col(j))) / size);
    }
  }
  return largest;
}

// A thousand lines with random phases correlate by 1 / sqrt(1000) = 0.03; five times that is one in
// a million.
constexpr double independent = 0.16;
const std::string density = "psd: [[1, 1e-4], [50, 1e-4]], period_s: 20, duration_s: 20";

TEST(NoiseStreams, OfDisturbancesAreTheirOwnAndNotTheFloors) {
  const Scene scene = parse_scene(scene_text, "scene.yaml");
  const Model model = make_model(scene);
  Disturbances disturbances(scene, model, 1 / rate);
  const Eigen::MatrixXd floor = floor_courses("noise: {axes: [x, y, z], " + density + "}");
  Eigen::MatrixXd courses(n, 2 + floor.cols());
  for (Eigen::Index k = 0; k < n; ++k) {
    disturbances.take(k);
    courses.row(k) << disturbances.values().transpose(), floor.row(k);
  }
  EXPECT_GT(courses.col(0).norm(), 0.0);
  EXPECT_GT(courses.col(2).norm(), 0.0);
  EXPECT_LT(largest_correlation(courses), independent);
}

TEST(NoiseStreams, OfAxesAndOfPartsOfASumAreTheirOwn) {
  // Each axis has its noise, whichever others are named.
  const auto alone = floor_courses("noise: {axes: [y], " + density + "}");
  const auto all = floor_courses("noise: {axes: [x, y, z, rx, ry, rz], " + density + "}");
  EXPECT_EQ(alone.col(1), all.col(1));
  EXPECT_LT(largest_correlation(all), independent);
  // The same twice is twice the power, not twice the amplitude; the first part is what it is alone.
  const auto sum = floor_courses("sum: [{noise: {axes: [y], " + density +
                                 "}}, {noise: {axes: [y], " + density + "}}]");
  Eigen::MatrixXd parts(n, 2);
  parts << alone.col(1), sum.col(1) - alone.col(1);
  EXPECT_NEAR(parts.col(1).norm() / parts.col(0).norm(), 1, 0.1);
  EXPECT_LT(largest_correlation(parts), independent);
  const auto white =
      floor_courses("sum: [{white: {rms: 1, duration_s: 20}}, {white: {rms: 1, duration_s: 20}}]");
  const auto one = floor_courses("white: {rms: 1, duration_s: 20}");
  parts << one.col(0), white.col(0) - one.col(0);
  EXPECT_LT(largest_correlation(parts), independent);
}

}  // namespace
}  // namespace stillframe
