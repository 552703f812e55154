#include <gtest/gtest.h>

#include <limits>

#include "report/live/wake_ups.hpp"
#include "tests/live/sample_messages.hpp"

namespace stillframe::live {
namespace {

using sample::record;
using sample::records;
using sample::second;

constexpr std::int64_t day = 86'400 * second;

TEST(WakeUps, KeepsTheWorstOfEachSecond) {
  WakeUps wake_ups;
  EXPECT_FALSE(wake_ups.any());
  EXPECT_FALSE(wake_ups.since(10, day).has_value());
  wake_ups.take(records(1, {record(5, 40, 7), record(1005, 90, 5)}), day);
  wake_ups.take(records(1, {record(9, 60, 9)}), day + 2 * second);
  const std::int64_t now = day + 2 * second + 1;
  ASSERT_TRUE(wake_ups.any());
  EXPECT_EQ(wake_ups.ago(2, now)->wake_up_ns, 90);
  EXPECT_EQ(wake_ups.ago(2, now)->compute_ns, 7);
  EXPECT_FALSE(wake_ups.ago(1, now).has_value());  // nothing came in it
  EXPECT_EQ(wake_ups.ago(0, now)->wake_up_ns, 60);
  EXPECT_EQ(wake_ups.since(1, now)->wake_up_ns, 60);
  EXPECT_EQ(wake_ups.since(2, now)->wake_up_ns, 90);
  EXPECT_EQ(wake_ups.since(2, now)->compute_ns, 9);
}

/// A minute is kept, and of a controller that has gone nothing is recent.
TEST(WakeUps, ForgetsAfterAMinute) {
  WakeUps wake_ups;
  for (std::int64_t s = 0; s < 200; ++s) {
    wake_ups.take(records(1, {record(5, 2000 - s, 1)}), day + s * second);
  }
  const std::int64_t now = day + 199 * second;
  EXPECT_EQ(wake_ups.since(59, now)->wake_up_ns, 2000 - 140);
  EXPECT_FALSE(wake_ups.ago(60, now).has_value());
  EXPECT_FALSE(wake_ups.since(10, now + 11 * second).has_value());
  EXPECT_TRUE(wake_ups.since(11, now + 11 * second).has_value());
}

TEST(WakeUps, TheLargestNumbersDoNoHarm) {
  WakeUps wake_ups;
  auto wild = record(5, 0, 0);
  wild.wake_up_ns = std::numeric_limits<std::int64_t>::max();
  wild.deadline_ns = wild.computed_ns = std::numeric_limits<std::int64_t>::min();
  wake_ups.take(records(1, {wild}), day);
  EXPECT_TRUE(wake_ups.any());
}

}  // namespace
}  // namespace stillframe::live
