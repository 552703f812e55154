#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "controller/supervisor.hpp"
#include "stillframe_msgs/controller_status_t.hpp"

namespace stillframe::controller {

/// Whether a plant has said since then (CLOCK_MONOTONIC, ns; 0: it does not) that it obeys another
/// controller, and for longer than it does of one that is gone, whose force its amplifiers hold.
bool is_overruled(std::int64_t since_ns, std::int64_t now_ns, double sample_rate_hz) noexcept;

/// Which of two controllers of one run gives way: who holds the frame stays; where both do, or
/// none, who began first (began_first). Set-up.
class Presence {
 public:
  Presence(std::int64_t instance, std::int64_t started_ns)
      : instance_(instance), started_ns_(started_ns) {}

  /// Why this controller, being in a state itself, gives way to the one that says so; none if it
  /// stays.
  std::optional<std::string> reason_to_leave(
      State own, const stillframe_msgs::controller_status_t& other) const;

  std::int64_t instance() const { return instance_; }
  std::int64_t started_ns() const { return started_ns_; }

 private:
  std::int64_t instance_, started_ns_;
};

}  // namespace stillframe::controller
