#include <gtest/gtest.h>

#include <random>

#include "report/analysis/floor_samples.hpp"
#include "tests/report/sample_log.hpp"

namespace stillframe::report {
namespace {

using Eigen::Index;

/// The samples of a floor in blocks, some of them lost.
FloorSamples samples_of(const Eigen::MatrixXd& floor, Index block, Index lost_first = 0,
                        Index lost_last = -1) {
  auto info = sample_info(1, floor.rows());
  info.n_floor = static_cast<std::int32_t>(floor.cols());
  FloorSamples samples(info);
  const auto add = [&](Index first, Index end) {
    for (; first < end; first += block) {
      SampleBlock part;
      part.first_seq = first;
      part.floor_acceleration = floor.middleRows(first, std::min(block, end - first));
      part.time_s.resize(part.floor_acceleration.rows());
      samples.add(part);
    }
  };
  if (lost_last < lost_first) {
    add(0, floor.rows());
  } else {
    add(0, lost_first);
    add(lost_last + 1, floor.rows());
  }
  return samples;
}

TEST(FloorSamples, TellOneFloorFromAnother) {
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  // More than is kept: of 3 inputs every fourth sample.
  const Eigen::MatrixXd floor =
      Eigen::MatrixXd::NullaryExpr(600000, 3, [&] { return 1e-3 * normal(random); });
  const FloorSamples whole = samples_of(floor, 4096);
  EXPECT_TRUE(whole.agrees(samples_of(floor, 1000)));
  EXPECT_TRUE(whole.agrees(samples_of(floor, 1001, 2998, 5003)));
  EXPECT_TRUE(whole.agrees(samples_of(floor, 1001, 0, 599990)));
  EXPECT_TRUE(whole.agrees(samples_of(floor * (1 + 1e-12), 4096))) << "rounding";
  EXPECT_FALSE(whole.agrees(samples_of(floor * 100, 4096)));
  EXPECT_FALSE(whole.agrees(samples_of(-floor, 4096)));
  EXPECT_FALSE(whole.agrees(samples_of(floor * 100, 1001, 2998, 5003)));
  // One shock of 10 samples more.
  Eigen::MatrixXd shaken = floor;
  shaken.middleRows(300000, 10).col(1).array() += 1e-3;
  EXPECT_FALSE(whole.agrees(samples_of(shaken, 4096)));
  // What is no number says nothing of the floor, and the log fails for it.
  Eigen::MatrixXd damaged = floor;
  damaged(400, 2) = std::nan("");
  EXPECT_TRUE(whole.agrees(samples_of(damaged, 4096)));
  EXPECT_FALSE(whole.agrees(samples_of(floor.topRows(300), 4096)));
}

}  // namespace
}  // namespace stillframe::report
