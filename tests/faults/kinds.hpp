#pragma once

#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/faults/rig.hpp"

namespace stillframe::faults {

/// The scene of one episode.
struct Stage {
  Rig& rig;
  std::mt19937_64& random;
  std::uint64_t seed = 0;

  /// Even from low to high.
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  }
  std::int64_t whole_between(std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(high - low + 1));
  }
};

/// Where the messages go through what the relay can do; nothing to count where they do not.
enum class Counted { nothing, measurements_lost, messages_bad, duplicates };

/// A row of the fault table.
struct Kind {
  std::string name;
  /// What may come of an episode, in the words of Episode::outcome.
  std::vector<std::string> allowed;
  /// Makes the fault happen, and returns when it is over.
  std::function<void(Stage&)> inflict = {};
  Counted counted = Counted::nothing;
  bool plant_restarts = false, controller_restarts = false;
  bool stops_time = false;  ///< samples are late because that is the fault
  bool delays = false;      ///< the relay holds measurements back
  bool alone = false;       ///< it would disturb others beside it
  std::vector<std::string> controller_prefix = {};
  /// Of the passive frame's peak, in an episode that the machine did not disturb. That the frame is
  /// let go of within a second, and not at once, moves it by up to 0.75 % of the floor's
  /// acceleration (docs/safety.md): the hundredth.
  double at_most = 1.01;
};

/// The rows: what happens on the wire, to the values of measurements, and to the processes.
std::vector<Kind> wire_kinds();
std::vector<Kind> corruption_kinds();
std::vector<Kind> process_kinds();
/// All rows, in the order of the table.
std::vector<Kind> all_kinds();

}  // namespace stillframe::faults
