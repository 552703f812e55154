#pragma once

#include <optional>
#include <vector>

#include "tests/faults/episodes.hpp"

namespace stillframe::faults {

/// A moment of an episode.
struct Mark {
  std::size_t run = 0;  ///< plant processes so far
  std::int64_t sample = 0;
  std::int64_t time_ns = 0;  ///< CLOCK_MONOTONIC
  std::size_t n_statuses = 0, n_periods = 0;
  RelayCounts counts;
};

/// The moments of an episode: just before the fault, at its end, at the reset of a latched one,
/// when it was active again, and a while later.
struct Marks {
  std::uint64_t seed = 0;
  Mark before, after;
  std::optional<Mark> reset;
  Mark recovered, end;
};

/// What an episode was, from all that the relay saw.
Episode judge(Workbench& bench, const Trace& trace, const Kind& kind, const Marks& marks);

}  // namespace stillframe::faults
