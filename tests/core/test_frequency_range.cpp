#include <gtest/gtest.h>

#include "core/systems/frequency_range.hpp"

namespace stillframe::test {
namespace {

using Eigen::VectorXd;

void expect_range(const FrequencyRange& found, double lowest_hz, double highest_hz) {
  EXPECT_DOUBLE_EQ(found.lowest_hz, lowest_hz);
  EXPECT_DOUBLE_EQ(found.highest_hz, highest_hz);
}

TEST(FrequencyRange, ShowsModesAndTargetsAndEndsAtHalfTheRate) {
  const VectorXd frame{{13.9, 13.9, 20.0, 31.3, 31.3, 49.0}};
  expect_range(frequency_range(frame, {5}, 1000), 0.5, 200);
  expect_range(frequency_range(frame, {5}, 300), 0.5, 150);
  expect_range(frequency_range(VectorXd{{207.0}}, {20}, 1000), 2, 500);
  expect_range(frequency_range(VectorXd{{0.36}}, {}, 0), 0.02, 2);
  expect_range(frequency_range(VectorXd{{0.36}}, {0.1, 0.2}, 1000), 0.01, 2);
  // A target beyond half the rate: an axis all the same.
  expect_range(frequency_range(VectorXd{{900.0}}, {800}, 1000), 50, 500);
  expect_range(frequency_range({}, {}, 1000), 0.5, 500);
  expect_range(frequency_range({}, {}, 0), 0.1, 1000);
  // A beam in many parts.
  expect_range(frequency_range(VectorXd::LinSpaced(200, 10, 2000), {}, 0), 1, 500);
}

TEST(FrequencyRange, OneThatRoundingMovedIsRoundAsItIs) {
  EXPECT_EQ(rounded_up(0.021), 0.05);
  EXPECT_EQ(rounded_up(7.0), 10);
  // By a unit in the last place or some, as a width that was divided: 0.02 is meant.
  EXPECT_EQ(rounded_up(0.02 * (1 + 1e-15)), 0.02);
  EXPECT_EQ(rounded_up(0.02 * (1 - 1e-15)), 0.02);
}

TEST(FrequencyRange, RoundNumbersAreThoseThatAreWrittenSo) {
  EXPECT_EQ(round_frequencies({0.05, 2}), (std::vector<double>{0.05, 0.1, 0.2, 0.5, 1, 2}));
  EXPECT_EQ(round_frequencies({0.3, 150}), (std::vector<double>{0.5, 1, 2, 5, 10, 20, 50, 100}));
}

}  // namespace
}  // namespace stillframe::test
