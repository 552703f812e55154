#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "controller/loop.hpp"
#include "controller/policy.hpp"

namespace stillframe::controller {

/// The thread of a loop. However its scope is left, by an exception as well, it lets go of the
/// frame before it ends. Set-up.
class LoopThread {
 public:
  /// loop outlives the thread. Asks for real time as the policy says.
  LoopThread(Loop& loop, const Policy& policy, double sample_rate_hz);
  /// Lets go, unless the thread has ended before; takes no longer than ramp_out_s + fade_s and 0.5
  /// s or five periods.
  ~LoopThread();
  LoopThread(const LoopThread&) = delete;
  LoopThread& operator=(const LoopThread&) = delete;

  /// Asks for a ramp to no force.
  void let_go() noexcept;
  /// After let_go: true once there is no force any more, or nobody to be let go: no measurement has
  /// come for hold_periods and 0.1 s, and for two periods, or the ramp is overdue.
  bool has_let_go() noexcept;
  /// Ends the thread as the loop is.
  void end() noexcept;

 private:
  Loop& loop_;
  std::int64_t most_ns_, silence_ns_;
  std::int64_t until_ns_ = 0, answered_ns_ = 0, n_answered_ = 0;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace stillframe::controller
