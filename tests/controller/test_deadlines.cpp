#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "controller/deadlines.hpp"

namespace stillframe::controller {
namespace {

TEST(Deadlines, KeepTheirPhaseForEver) {
  const std::int64_t start = 123'456'789'012'345;
  Deadlines deadlines(start, 3000, 0.3);  // a period of 333333.33 ns
  for (std::int64_t k = 0; k < 1'000'000; ++k) {
    const std::int64_t next = deadlines.next_ns();
    const auto exact = static_cast<long double>(k) + 0.3L;
    // Half a ns of rounding, no drift after a million periods.
    ASSERT_NEAR(static_cast<double>(next - start), static_cast<double>(exact * 1e9L / 3000), 0.51);
    const auto wake_up = deadlines.wake_up(next + 20'000);
    ASSERT_EQ(wake_up.past_deadline_ns, 20'000);
    ASSERT_EQ(wake_up.n_skipped, 0);
  }
}

TEST(Deadlines, LatePeriodsAreSkippedWholeAndCounted) {
  Deadlines deadlines(0, 1000, 0.5);
  EXPECT_EQ(deadlines.next_ns(), 500'000);
  EXPECT_EQ(deadlines.wake_up(1'499'999).n_skipped, 0);  // a ns before the next deadline
  EXPECT_EQ(deadlines.next_ns(), 1'500'000);
  const auto wake_up =
      deadlines.wake_up(4'700'000);  // 1.5 -> 4.7 ms: 2.5 and 3.5 went by, 4.5 is served
  EXPECT_EQ(wake_up.past_deadline_ns, 3'200'000);
  EXPECT_EQ(wake_up.n_skipped, 3);
  EXPECT_EQ(deadlines.next_ns(), 5'500'000);
}

TEST(Deadlines, BeginAnewFromAnyNumber) {
  Deadlines deadlines(0, 1000, 0.5);
  // Number 5000 is at 77 ms: at 79.6 ms 5002.5 is over, and 5003.5 the next.
  deadlines.begin(77'000'000, 5000, 79'600'000);
  EXPECT_EQ(deadlines.next_ns(), 80'500'000);
  deadlines.follow(77'000'000 + 3'000'300, 5003, 1'000'100);
  EXPECT_EQ(deadlines.next_ns(), 77'000'000 + 3'000'300 + 500'050);
}

TEST(Deadlines, BadArgumentsAreRefused) {
  EXPECT_THROW(Deadlines(0, 0, 0.3), std::invalid_argument);
  EXPECT_THROW(Deadlines(0, 1000, 1), std::invalid_argument);
  EXPECT_THROW(Deadlines(0, 1000, -0.1), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe::controller
