#include <gtest/gtest.h>

#include <iostream>

#include "tests/stalls/trials.hpp"

// A few trials of each stall; scripts/stall_trials makes a thousand.
namespace stillframe::stalls {
namespace {

/// Those of all_stalls() from a number on, up to another.
struct Part {
  const char* name;
  std::size_t first, end;
};

// Most of the time goes by waiting for a loop that starts again: parts of the list run beside each
// other.
class Stalls : public testing::TestWithParam<Part> {};

TEST_P(Stalls, NeverTwoForcesForOneSampleAndEachStopIsObeyed) {
  faults::Workbench bench;
  const std::vector<Stall> stalls = all_stalls();
  ASSERT_LE(GetParam().end, stalls.size());
  std::uint64_t seed = GetParam().first;
  for (std::size_t i = GetParam().first; i < GetParam().end; ++i) {
    const Stall& stall = stalls[i];
    // A machine that takes the processor away from one of many processes for longer than its
    // witnesses say does so twice in a row far more seldom than a defect.
    Batch batch;
    for (int attempt = 0; attempt < 2; ++attempt) {
      batch = run_batch(bench, stall, {.n_trials = 3, .seed = ++seed});
      if (batch.failures.empty()) break;
      for (const auto& failure : batch.failures) std::cout << "attempt: " << failure << "\n";
    }
    for (const std::string& failure : batch.failures) ADD_FAILURE() << failure;
    EXPECT_EQ(batch.trials.size(), stall.handed_over ? 2u : 3u) << stall.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Parts, Stalls,
                         testing::Values(Part{"Terminals", 0, 3},
                                         Part{"PipesAndAHangingDisk", 3, 6},
                                         Part{"AFullDiskAndSuspensions", 6, 8},
                                         Part{"AnotherControllerAndTwoAtOnce", 8, 10}),
                         [](const auto& part) { return std::string(part.param.name); });

// So that none is left out.
TEST(StallsInParts, AreAll) { EXPECT_EQ(all_stalls().size(), 10u); }

}  // namespace
}  // namespace stillframe::stalls
