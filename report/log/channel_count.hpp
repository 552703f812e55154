#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stillframe::report {

/// Consecutive sequence numbers first .. last that never reached the log.
struct SequenceGap {
  std::int64_t first = 0;
  std::int64_t last = 0;
};

/// The messages of one channel after identical repeats were dropped: what came, and what did not.
struct ChannelCount {
  std::int64_t n_received = 0;      ///< distinct messages
  std::int64_t n_duplicates = 0;    ///< identical repeats, dropped
  std::int64_t n_out_of_order = 0;  ///< messages logged after one with a larger seq
  std::int64_t n_lost = 0;          ///< sum over gaps
  std::int64_t n_after = 0;         ///< of these: behind the last that came
  std::vector<SequenceGap> gaps;    ///< in increasing order, at most most_gaps of them

  /// Sample times from the first to the last that came.
  std::int64_t n_spanned() const { return n_received + n_lost - n_after - 1; }

  /// So that a log in which every other message is missing takes no memory of its length.
  static constexpr std::size_t most_gaps = 100'000;
};

}  // namespace stillframe::report
