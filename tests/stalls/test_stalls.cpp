#include <gtest/gtest.h>

#include <iostream>

#include "tests/stalls/trials.hpp"

// A few trials of each stall; scripts/stall_trials makes a thousand.
namespace stillframe::stalls {
namespace {

TEST(Stalls, NeverTwoForcesForOneSampleAndEachStopIsObeyed) {
  faults::Workbench bench;
  std::uint64_t seed = 0;
  for (const Stall& stall : all_stalls()) {
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

}  // namespace
}  // namespace stillframe::stalls
