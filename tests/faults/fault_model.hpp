#pragma once

#include <cstdint>
#include <deque>
#include <random>
#include <vector>

namespace stillframe::faults {

using Bytes = std::vector<std::uint8_t>;

/// What a bad wire does to the messages of one direction; nothing by default.
struct Disturbance {
  double loss = 0;            ///< probability that a message is lost
  double burst = 0;           ///< probability that a burst of losses begins with a message
  int burst_length = 0;       ///< messages that a burst takes
  double delay_periods = 0;   ///< every message is late by so many periods
  double jitter_periods = 0;  ///< and by 0 to so many more, evenly distributed
  double duplication = 0;     ///< probability that a message comes twice
  double reordering = 0;      ///< probability that a message comes right behind the next
};

/// A message and when it goes on.
struct Departure {
  std::int64_t leave_ns = 0;
  Bytes bytes;
};

/// What became of the messages.
struct WireCounts {
  std::int64_t n_passed = 0;  ///< that came to the wire
  std::int64_t n_lost = 0, n_duplicated = 0, n_reordered = 0;
};

/// A seeded bad wire: the same seed does the same to the same messages, whatever the machine.
/// It knows nothing of sockets or clocks.
class FaultModel {
 public:
  FaultModel(const Disturbance& disturbance, std::uint64_t seed, std::int64_t period_ns);

  /// Takes a message that came at now_ns; appends what leaves, in no order of time.
  void pass(Bytes message, std::int64_t now_ns, std::vector<Departure>& out);
  /// The end: gives out what is held back.
  void release(std::int64_t now_ns, std::vector<Departure>& out);

  const WireCounts& counts() const { return counts_; }

 private:
  void let_go(std::int64_t now_ns, std::vector<Departure>& out);
  /// Even in [0, 1), the same with every standard library.
  double random() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

  Disturbance disturbance_;
  std::mt19937_64 engine_;
  double period_ns_;
  int burst_left_ = 0;
  std::deque<Bytes> held_back_;
  WireCounts counts_;
};

}  // namespace stillframe::faults
