#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "tests/faults/fault_model.hpp"

namespace stillframe::faults {

/// One direction of the relay: messages wait here until they leave. Good until a fault begins.
class Wire {
 public:
  static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

  explicit Wire(std::int64_t period_ns) : period_ns_(period_ns) {}

  void begin(const Disturbance& disturbance, std::uint64_t seed);
  /// What is held back leaves, what is delayed stays so.
  void end(std::int64_t now_ns);

  void pass(Bytes message, std::int64_t now_ns);
  /// The next message whose time has come; messages of one time leave in their order.
  std::optional<Bytes> take(std::int64_t now_ns);
  /// When the next leaves, never if there is none.
  std::int64_t next_ns() const { return queue_.empty() ? never : queue_.top().leave_ns; }

  /// Of all faults.
  WireCounts counts() const;

 private:
  struct Waiting {
    std::int64_t leave_ns;
    std::uint64_t order;
    Bytes bytes;
    bool operator<(const Waiting& other) const {
      return std::pair(leave_ns, order) > std::pair(other.leave_ns, other.order);
    }
  };
  void add(std::vector<Departure>& departures);

  std::int64_t period_ns_;
  std::optional<FaultModel> model_;
  WireCounts past_;
  std::priority_queue<Waiting> queue_;
  std::uint64_t n_ = 0;
};

}  // namespace stillframe::faults
