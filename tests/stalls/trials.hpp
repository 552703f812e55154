#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/faults/workbench.hpp"
#include "tests/stalls/terminal.hpp"

namespace stillframe::stalls {

/// What happens to the controller meanwhile.
struct Stall {
  std::string name;
  Reader reader = Reader::file;
  std::string disk = {};     ///< "hangs" or "full"
  bool suspended = false;    ///< SIGSTOP for up to 0.3 s in every trial, which is a fault as well
  bool handed_over = false;  ///< SIGSTOP while a second controller comes
};

std::vector<Stall> all_stalls();

struct Trial {
  double obeyed_s = 0;   ///< from the request on the bus, or the signal, to the command that obeys
  double told_s = 0;     ///< to a status that says so
  double machine_s = 0;  ///< latest wake-up of a thread that only wakes up, meanwhile
};

/// All trials of one plant, one controller and another that wants its place.
struct Batch {
  std::string stall;
  std::vector<Trial> trials;
  std::int64_t n_commands = 0, n_two_forces = 0;
  std::vector<std::string> failures;
};

struct BatchOptions {
  int n_trials = 4;  ///< the last is a SIGTERM, the others are `stillframe ctl stop`
  std::uint64_t seed = 1;
  std::filesystem::path controller =
      {};  ///< another program in its place; empty: the one of this build
};

/// The longest that a stop may take where the machine is not late, s.
constexpr double longest_s = 0.1;

/// Runs one batch. What is wrong is in its failures.
Batch run_batch(faults::Workbench& bench, const Stall& stall, const BatchOptions& options);

}  // namespace stillframe::stalls
