#include <gtest/gtest.h>

#include <limits>

#include "plant_sim/command_queue.hpp"
#include "tests/plant_sim/frame.hpp"

namespace stillframe {
namespace {

/// Command u[k] = k + 1 on the first leg, its negative on the second; zero before the first.
Eigen::VectorXd command(int k) { return (k < 0 ? 0.0 : k + 1.0) * Eigen::Vector2d(1, -1); }

class CommandQueueTest : public testing::TestWithParam<double> {};

TEST_P(CommandQueueTest, CommandsTakeEffectSoManySamplesLater) {
  const double delay = GetParam();
  CommandQueue queue(2, delay);
  EXPECT_EQ(queue.needs_answer(), delay < 1);
  for (int k = 0; k < 120; ++k) {
    if (queue.needs_answer()) queue.push(command(k));
    // Midpoints of 64 pieces of the interval; none is where a command of the delays below begins.
    for (int i = 0; i < 64; ++i) {
      const double part = (i + 0.5) / 64;
      // By the definition: the newest u[j] with j + delay before k + part.
      int newest = -1;
      while (newest + 1 + delay <= k + part) ++newest;
      ASSERT_EQ(part < queue.fraction() ? queue.before() : queue.after(), command(newest))
          << "sample " << k << " part " << part;
    }
    if (!queue.needs_answer()) queue.push(command(k));
  }
}

INSTANTIATE_TEST_SUITE_P(Delays, CommandQueueTest,
                         testing::Values(0.0, 0.3, 0.75, 1.0, 1.5, 2.0, 2.25, 3.9, 100.0));

TEST(CommandQueue, RefusesANegativeDelay) {
  EXPECT_THROW(CommandQueue(2, -0.1), std::invalid_argument);
  EXPECT_THROW(CommandQueue(2, std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  EXPECT_THROW(CommandQueue(2, std::numeric_limits<double>::infinity()), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe
