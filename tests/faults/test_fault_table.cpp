#include <gtest/gtest.h>

#include <iostream>

#include "tests/faults/table.hpp"

// The fault table with real processes, three seeds of each kind; scripts/fault_table takes ten.
namespace stillframe::faults {
namespace {

/// What is wrong with rows of the table.
std::vector<std::string> trouble_with(const std::vector<KindResult>& results) {
  std::vector<std::string> all;
  for (const KindResult& result : results) {
    for (const std::string& failure : failures(result)) all.push_back(failure);
    // So that a row cannot pass by having had no episodes.
    EXPECT_EQ(result.episodes.size(), 3u) << result.name;
  }
  return all;
}

/// Runs rows of the table and states what is wrong. A row that went wrong beside others gets a
/// second chance by itself: a machine that takes the processor away for longer than the policy
/// holds looks like a fault, and does so twice in a row far more seldom than a defect.
void expect_rows(const std::vector<Kind>& kinds) {
  Workbench bench;
  const TableOptions options{.seeds = {1, 2, 3}, .policy = {}, .samples = {}};
  const auto results = run_kinds(bench, kinds, options);
  std::cout << markdown(results);
  std::string not_judged;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const auto first = trouble_with({results[i]});
    if (first.empty()) continue;
    for (const std::string& failure : first) std::cout << "once more: " << failure << "\n";
    const KindResult second = run_kind(bench, kinds[i], 0, options);
    if (second.by_machine) {
      not_judged += second.trouble + "\n";
      continue;
    }
    for (const std::string& failure : trouble_with({second})) ADD_FAILURE() << failure;
  }
  // A witness beside the loop saw it: of the controller nothing was learnt.
  if (!not_judged.empty()) GTEST_SKIP() << not_judged;
}

TEST(FaultTableThreeSeeds, Wires) { expect_rows(wire_kinds()); }

TEST(FaultTableThreeSeeds, Corruptions) { expect_rows(corruption_kinds()); }

std::vector<Kind> kinds_of_processes(bool alone) {
  std::vector<Kind> kinds = process_kinds();
  std::erase_if(kinds, [alone](const Kind& kind) { return kind.alone != alone; });
  return kinds;
}

TEST(FaultTableThreeSeeds, Processes) { expect_rows(kinds_of_processes(false)); }

// Takes the processor from whatever runs beside it: nothing may.
TEST(FaultTableThreeSeedsAlone, Processes) { expect_rows(kinds_of_processes(true)); }

}  // namespace
}  // namespace stillframe::faults
