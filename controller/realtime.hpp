#pragma once

#include <string>

namespace stillframe::controller {

/// Asks the system for what wall-clock runs gain from, SCHED_FIFO scheduling and locked memory, for
/// this thread and those it starts later; answers in words what was obtained. Set-up. Errors: none,
/// a run goes on without.
std::string request_realtime();

/// Lets timers of this thread fire as close to their deadline as the system can. Set-up.
void request_fine_timers() noexcept;

}  // namespace stillframe::controller
