#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "report/analysis/duration_histogram.hpp"
#include "report/analysis/level_track.hpp"

namespace stillframe::report {
namespace {

using Eigen::VectorXd;

TEST(LevelTrack, IsTheRmsOfEachTenthOfASecond) {
  LevelTrack track(1000);
  VectorXd x(250);
  x.head(100).setConstant(2);
  x.segment(100, 100) << VectorXd::Constant(50, 3), VectorXd::Constant(50, -1);
  x.tail(50).setConstant(9);  // no whole tenth
  for (Eigen::Index k = 0; k < x.size(); k += 25) track.add(x.segment(k, 25));
  ASSERT_EQ(track.levels().size(), 2u);
  EXPECT_EQ(track.levels()[0], 2);
  EXPECT_EQ(track.levels()[1], std::sqrt(5.0));
}

TEST(LevelTrack, MissingSamplesLeaveOutTheirTenths) {
  LevelTrack track(1000);
  track.add(VectorXd::Constant(120, 1));
  track.skip(200);
  track.add(VectorXd::Constant(80, 5));
  ASSERT_EQ(track.levels().size(), 4u);
  EXPECT_EQ(track.levels()[0], 1);
  EXPECT_EQ(track.levels()[1], 1);
  EXPECT_TRUE(std::isnan(track.levels()[2]));
  EXPECT_EQ(track.levels()[3], 5);
}

TEST(LevelTrack, TenthsNeedNotBeWholeSamples) {
  LevelTrack track(1024);
  for (int i = 0; i < 10; ++i) track.add(VectorXd::Ones(1024));
  EXPECT_EQ(track.levels().size(), 100u);
}

/// A quiet floor with a shock of so many tenths at 5 s, and a frame that rings down with a time
/// constant.
struct Levels {
  std::vector<double> floor, frame;
};
Levels shaken(double time_constant_s, int n = 300) {
  Levels levels{std::vector<double>(static_cast<std::size_t>(n), 1.0),
                std::vector<double>(static_cast<std::size_t>(n), 0.5)};
  for (std::size_t i = 0; i < levels.floor.size(); ++i) {
    if (i >= 50 && i < 53) levels.floor[i] = 100;
    if (i >= 50) {
      const double t = 0.1 * static_cast<double>(i - 50);
      levels.frame[i] = std::hypot(0.5, 40 * std::exp(-t / time_constant_s));
    }
  }
  return levels;
}

TEST(Shocks, AreFoundWithTheTimeToSettle) {
  const Levels levels = shaken(0.5);
  const auto shocks = find_shocks(levels.floor, levels.frame);
  ASSERT_EQ(shocks.size(), 1u);
  EXPECT_NEAR(shocks[0].time_s, 5.05, 1e-12);
  EXPECT_EQ(shocks[0].floor_level, 100);
  EXPECT_NEAR(shocks[0].frame_level, 40, 0.01);
  // Below 5 % of 40 after ln(20) time constants, 1.50 s, that is in the first tenth after it.
  ASSERT_TRUE(shocks[0].settling_s.has_value());
  EXPECT_NEAR(*shocks[0].settling_s, 1.5, 0.1 + 1e-9);
}

TEST(Shocks, AFrameThatRingsOnHasNotSettled) {
  const Levels levels = shaken(1e3);
  const auto shocks = find_shocks(levels.floor, levels.frame);
  ASSERT_EQ(shocks.size(), 1u);
  EXPECT_FALSE(shocks[0].settling_s.has_value());
}

TEST(Shocks, ABlowOnTheFrameIsOneWithoutTheFloor) {
  Levels levels = shaken(0.5);
  for (double& level : levels.floor) level = 1;
  const auto shocks = find_shocks(levels.floor, levels.frame);
  ASSERT_EQ(shocks.size(), 1u);
  EXPECT_EQ(shocks[0].floor_level, 1);
  EXPECT_NEAR(shocks[0].time_s, 5.05, 1e-12);
}

TEST(Shocks, NextShockEndsTheTimeOfTheLast) {
  Levels levels = shaken(1e3);
  for (std::size_t i = 53; i < 100; ++i) levels.frame[i] = 0.5;  // it is stopped at 5.3 s
  for (std::size_t i = 100; i < levels.frame.size(); ++i) levels.frame[i] = 0.5;
  levels.floor[200] = 80;
  levels.frame[200] = 30;
  const auto shocks = find_shocks(levels.floor, levels.frame);
  ASSERT_EQ(shocks.size(), 2u);
  EXPECT_NEAR(shocks[0].settling_s.value_or(-1), 0.3, 1e-9);
  EXPECT_NEAR(shocks[1].time_s, 20.05, 1e-9);
  EXPECT_NEAR(shocks[1].settling_s.value_or(-1), 0.1, 1e-9);
}

/// Slow Gaussian motion, of which a tenth of a second is one sample: levels from nothing to 4
/// sigma.
TEST(Shocks, SteadyNoiseHasNoneAndDoesNotHideThatTheFrameSettles) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  std::vector<double> floor, frame;
  for (int i = 0; i < 36000; ++i) {
    floor.push_back(std::abs(normal(random)));
    frame.push_back(0.1 * std::abs(normal(random)));
  }
  EXPECT_TRUE(find_shocks(floor, frame).empty());
  for (std::size_t i = 20000; i < 20100; ++i) {
    const double t = 0.1 * static_cast<double>(i - 20000);
    if (t < 0.3) floor[i] += 100;
    frame[i] += 10 * std::exp(-t);
  }
  const auto shocks = find_shocks(floor, frame);
  ASSERT_EQ(shocks.size(), 1u);
  // Below 4 times 0.1 after ln(25) = 3.2 s, below 5 % of 10 after 3.0.
  ASSERT_TRUE(shocks[0].settling_s.has_value());
  EXPECT_NEAR(*shocks[0].settling_s, 3, 0.5);
}

TEST(Shocks, AreOnPlantTime) {
  const Levels levels = shaken(0.5);
  EXPECT_NEAR(find_shocks(levels.floor, levels.frame, 30).at(0).time_s, 35.05, 1e-12);
}

TEST(Shocks, ASteadyFloorHasNone) {
  std::vector<double> floor, frame;
  for (int i = 0; i < 1000; ++i) {
    floor.push_back(1 + 0.8 * std::sin(0.37 * i));
    frame.push_back(0.1 + 0.05 * std::sin(0.11 * i));
  }
  EXPECT_TRUE(find_shocks(floor, frame).empty());
  EXPECT_TRUE(find_shocks({}, {}).empty());
  EXPECT_TRUE(find_shocks(std::vector<double>(100, 0.0), std::vector<double>(100, 0.0)).empty());
}

TEST(DurationHistogram, CountsByBinsOfATenthDecade) {
  DurationHistogram histogram;
  for (int i = 1; i <= 1000; ++i) histogram.add(1000 * i);  // 1 us to 1 ms
  EXPECT_EQ(histogram.count(), 1000);
  EXPECT_EQ(histogram.largest_ns(), 1'000'000);
  // The median is 500 us: the bin's upper edge 501.2 us.
  EXPECT_NEAR(histogram.quantile_us(0.5), std::pow(10, 2.7), 1e-9);
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < histogram.counts().size(); ++i) sum += histogram.counts()[i];
  EXPECT_EQ(sum, 1000);
  EXPECT_EQ(histogram.edges_us().size(), histogram.counts().size() + 1);
}

TEST(DurationHistogram, WhatIsOutsideFallsIntoTheEnds) {
  DurationHistogram histogram;
  histogram.add(-5);
  histogram.add(0);
  histogram.add(1'000'000'000'000);
  EXPECT_EQ(histogram.counts().front(), 2);
  EXPECT_EQ(histogram.counts().back(), 1);
}

}  // namespace
}  // namespace stillframe::report
