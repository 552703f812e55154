#pragma once

#include <cstdint>
#include <vector>

#include "stillframe_msgs/control_request_t.hpp"

namespace stillframe::controller {

/// Which requests are to be obeyed: each once, only while it is fresh, and none that was asked
/// before another that was obeyed, so that a START heard late or again does not undo a STOP. A STOP
/// is obeyed whatever came after it. Set-up.
class Requests {
 public:
  /// Whether this one is to be obeyed; if so it never is again. now_ns: CLOCK_MONOTONIC.
  bool admits(const stillframe_msgs::control_request_t& request, std::int64_t now_ns);

 private:
  std::vector<std::int64_t> obeyed_;  ///< their nonces, oldest first
  std::int64_t last_asked_ns_ = 0;
};

}  // namespace stillframe::controller
