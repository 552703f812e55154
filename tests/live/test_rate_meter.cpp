#include <gtest/gtest.h>

#include "report/live/rate_meter.hpp"

namespace stillframe::live {
namespace {

constexpr std::int64_t ms = 1'000'000;

TEST(RateMeter, NothingHasNoRate) {
  const RateMeter meter;
  EXPECT_EQ(meter.per_s(5000 * ms), 0);
  EXPECT_EQ(meter.n(), 0);
  EXPECT_LT(meter.last_ns(), 0);
}

/// Whole slots of 250 ms of a message every 2 ms hold 125 each, wherever they begin.
TEST(RateMeter, SteadyMessagesHaveTheirRateAtAnyTime) {
  RateMeter meter;
  for (std::int64_t t = 7'000; t < 20'000; t += 2) {
    meter.count(t * ms);
    if (t < 7'600) continue;
    EXPECT_DOUBLE_EQ(meter.per_s(t * ms), 500) << t;
  }
  EXPECT_EQ(meter.n(), 6500);
  EXPECT_EQ(meter.last_ns(), 19'998 * ms);
}

TEST(RateMeter, TheRateOfWhatHasStoppedFallsToZeroInTwoSeconds) {
  RateMeter meter;
  for (std::int64_t t = 0; t < 8'000; t += 10) meter.count(t * ms);
  EXPECT_DOUBLE_EQ(meter.per_s(9'000 * ms), 50);  // half of the last two seconds
  EXPECT_DOUBLE_EQ(meter.per_s(10'250 * ms), 0);
  EXPECT_DOUBLE_EQ(meter.per_s(1'000'000 * ms), 0);
}

/// After a long pause nothing of before is counted again.
TEST(RateMeter, APauseLeavesNothingBehind) {
  RateMeter meter;
  for (std::int64_t t = 0; t < 8'000; t += 10) meter.count(t * ms);
  for (std::int64_t t = 60'000; t < 60'500; t += 100) meter.count(t * ms);
  EXPECT_DOUBLE_EQ(meter.per_s(60'500 * ms), 2.5);  // 5 messages in the last 2 s
  EXPECT_EQ(meter.n(), 805);
}

}  // namespace
}  // namespace stillframe::live
