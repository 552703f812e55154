#pragma once

#include <optional>
#include <string>

#include "controller/policy.hpp"

namespace stillframe::controller {

/// What was asked of the system and what it gave, in words.
struct RealtimeReport {
  bool complete = false;  ///< all that was asked for
  std::string text;
};

/// Prepares the process for a loop that is on time: memory locked and never given back, small
/// stacks, no deep sleep of the processors; and tries on a thread of its own what prepare_thread
/// will get. Set-up. Errors: none, a loop goes on without; whoever enforces looks at complete.
RealtimeReport prepare_process(const Policy& policy);

/// For the calling thread: SCHED_FIFO at a priority, the processor if one is given, timers as close
/// to their deadline as the system can, and its stack touched. Set-up. The threads that it starts
/// inherit the priority.
RealtimeReport prepare_thread(std::int64_t priority, std::optional<std::int64_t> cpu);

/// For a thread without which the loop hears and says nothing: it does not wait for its turn behind
/// ordinary programs, and comes after the loop. Set-up.
void prepare_servant(const Policy& policy) noexcept;

}  // namespace stillframe::controller
