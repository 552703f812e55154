#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "tests/faults/table.hpp"

// The fault table with real processes, three seeds of each kind; scripts/fault_table takes ten.
namespace stillframe::faults {
namespace {

/// Runs the kinds of these names and states what is wrong.
void expect_rows(const std::vector<std::string>& names) {
  std::vector<Kind> kinds;
  for (Kind& kind : all_kinds()) {
    if (std::find(names.begin(), names.end(), kind.name) != names.end()) {
      kinds.push_back(std::move(kind));
    }
  }
  ASSERT_EQ(kinds.size(), names.size());
  Workbench bench;
  const auto results = run_kinds(bench, kinds, {.seeds = {1, 2, 3}, .policy = {}, .samples = {}});
  for (const KindResult& result : results) {
    for (const std::string& failure : failures(result)) ADD_FAILURE() << failure;
  }
  std::cout << markdown(results);
}

TEST(FaultTable, EveryKindIsInOneOfTheseTests) { EXPECT_EQ(all_kinds().size(), 26u); }

TEST(FaultTableThreeSeeds, WireLossesAndOrder) {
  expect_rows({"no fault", "loss 1 %", "loss 10 %", "loss 50 %", "bursts of 20 lost", "30 % twice",
               "30 % out of order"});
}

}  // namespace
}  // namespace stillframe::faults
