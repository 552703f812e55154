#include <gtest/gtest.h>

#include <iostream>

#include "tests/faults/table.hpp"

// The fault table with real processes, three seeds of each kind; scripts/fault_table takes ten.
namespace stillframe::faults {
namespace {

/// Runs rows of the table and states what is wrong.
void expect_rows(const std::vector<Kind>& kinds) {
  Workbench bench;
  const auto results = run_kinds(bench, kinds, {.seeds = {1, 2, 3}, .policy = {}, .samples = {}});
  std::cout << markdown(results);
  for (const KindResult& result : results) {
    for (const std::string& failure : failures(result)) ADD_FAILURE() << failure;
    // So that a row cannot pass by having had no episodes.
    EXPECT_EQ(result.episodes.size(), 3u) << result.name;
  }
}

TEST(FaultTableThreeSeeds, Wires) { expect_rows(wire_kinds()); }

TEST(FaultTableThreeSeeds, Corruptions) { expect_rows(corruption_kinds()); }

TEST(FaultTableThreeSeeds, Processes) { expect_rows(process_kinds()); }

}  // namespace
}  // namespace stillframe::faults
