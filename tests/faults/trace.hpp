#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "stillframe_msgs/controller_status_t.hpp"

namespace stillframe::faults {

/// Accelerations of the frame's six outputs in one sample, m/s^2.
using Accelerations = std::array<double, 6>;

/// Forces of the six actuators in one sample, N.
using Forces = std::array<double, 6>;

/// The samples of one plant process, in their order; those that the relay never saw are NaN.
struct RunTrace {
  std::vector<Accelerations> frame;
  std::vector<Forces> applied;
  std::vector<std::int64_t> arrival_ns;  ///< CLOCK_MONOTONIC at the relay, 0 if never seen
};

/// A status of the controller, and the newest sample when it came.
struct StatusAt {
  std::size_t run = 0;  ///< index of the plant process
  std::int64_t sample = 0;
  stillframe_msgs::controller_status_t status;
};

/// What delayed the controller in one period, from its own record.
struct PeriodAt {
  std::size_t run = 0;
  std::int64_t sample = 0;       ///< the newest when the record came
  std::int64_t defect = 0;       ///< as in controller/policy.hpp
  std::int64_t wake_up_ns = 0;   ///< past the deadline
  std::int64_t transit_ns = -1;  ///< of its measurement, from the relay to its receipt; -1: none
};

/// All that a relay saw.
struct Trace {
  std::vector<RunTrace> runs;
  std::vector<StatusAt> statuses;
  std::vector<PeriodAt> periods;

  /// Number of the newest sample, -1 before the first.
  std::int64_t sample() const {
    return runs.empty() ? -1 : static_cast<std::int64_t>(runs.back().frame.size()) - 1;
  }
  const stillframe_msgs::controller_status_t* status() const {
    return statuses.empty() ? nullptr : &statuses.back().status;
  }
};

}  // namespace stillframe::faults
