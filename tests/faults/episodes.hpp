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
  /// Peak of the frame's acceleration from the beginning of the fault until a while after it was
  /// active again, the worst of its six outputs, over that of a passive frame:
  double over_passive =
      0;  ///< the larger peak of over_minute and over_left: what must not be above 1
  double over_minute = 0;  ///< one that was always passive, in a minute of the same floor
  double over_same = 0;    ///< the same in the very samples of the episode
  double over_left = 0;    ///< one that was left to itself when the fault began
  /// By how much the frame behind over_left differs from what the relay saw before the fault.
  double model_error = 0;
  /// The machine itself was late by more than a few periods: the outcome says nothing.
  bool disturbed = false;
  std::string lateness;  ///< of the machine in words
  /// What the relay did to measurements, what the controller counted of it (Kind::counted), and
  /// the most that it may have counted: a busy machine makes it miss more than the relay took.
  std::int64_t n_inflicted = 0, n_counted = 0, n_at_most = 0;
};

/// A row of the table.
struct KindResult {
  std::string name;
  std::vector<std::string> allowed;
  double at_most = 1.01;  ///< as of its kind
  std::vector<Episode> episodes;
  std::optional<int> exit_code;  ///< of the controller, when the plant was ended by SIGTERM
  std::string trouble;           ///< why the episodes were broken off; empty: they were not
  bool by_machine = false;       ///< they were because the machine stood still again and again
};

/// What all kinds of a table have in common.
struct TableOptions {
  std::vector<std::uint64_t> seeds;
  std::string policy;             ///< text of a policy file; empty: the defaults
  std::filesystem::path samples;  ///< folder for every sample of every run; empty: not written
};

/// Runs one plant and controller through a fault once for each seed. number: which ports it takes.
KindResult run_kind(Workbench& bench, const Kind& kind, int number, const TableOptions& options);

/// Runs kinds side by side, at most three at once; those that want to be alone, and those that came
/// to no end beside others, by themselves.
std::vector<KindResult> run_kinds(Workbench& bench, const std::vector<Kind>& kinds,
                                  const TableOptions& options);

}  // namespace stillframe::faults
