#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/faults/kinds.hpp"
#include "tests/faults/workbench.hpp"

namespace stillframe::faults {

/// What came of one fault with one seed.
struct Episode {
  std::uint64_t seed = 0;
  /// active: it never let go; resumed: it faded and went on; joined: another controller, or a
  /// controller for another plant, took hold; else the last fault, with ", latched" if it stayed.
  std::string outcome;
  /// Samples from the end of the fault (a latched one: from the reset) until it was active.
  std::int64_t recovery = 0;
  /// Peak of the frame's acceleration from the beginning of the fault until it was active again,
  /// the worst of its six outputs, over that of the passive frame: over its peak in the whole run,
  /// its peak in these very samples, and its root mean square in the whole run.
  double over_peak = 0, over_same = 0, over_rms = 0;
  /// The machine itself was late by more than hold a fault: the outcome says nothing.
  bool disturbed = false;
  /// What the relay did to measurements and what the controller counted; equal where both speak of
  /// the same, see Kind::counted.
  std::int64_t n_inflicted = 0, n_counted = 0;
};

/// A row of the table.
struct KindResult {
  std::string name;
  std::vector<std::string> allowed;
  bool counts = false;  ///< n_inflicted and n_counted of the episodes must be equal
  std::vector<Episode> episodes;
  std::optional<int> exit_code;  ///< of the controller at the end
  std::string trouble;           ///< why the episodes were broken off; empty: they were not
};

/// What all kinds of a table have in common.
struct TableOptions {
  std::vector<std::uint64_t> seeds;
  std::string policy;             ///< text of a policy file; empty: the defaults
  std::filesystem::path samples;  ///< folder for every sample of every run; empty: not written
};

/// Runs one plant and controller through a fault once for each seed. number: which ports it takes.
KindResult run_kind(Workbench& bench, const Kind& kind, int number, const TableOptions& options);

/// Runs kinds side by side, at most three at once, and those that want to be alone by themselves.
std::vector<KindResult> run_kinds(Workbench& bench, const std::vector<Kind>& kinds,
                                  const TableOptions& options);

}  // namespace stillframe::faults
