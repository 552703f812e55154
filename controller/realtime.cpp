#include "controller/realtime.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstring>

namespace stillframe::controller {

namespace {

std::string request_fifo() {
  // Half way up: above every ordinary thread, below the kernel's own interrupt threads.
  const sched_param parameters{.sched_priority = sched_get_priority_max(SCHED_FIFO) / 2};
  if (sched_setscheduler(0, SCHED_FIFO, &parameters) == 0) {
    return "SCHED_FIFO priority " + std::to_string(parameters.sched_priority);
  }
  return std::string("no SCHED_FIFO (") + std::strerror(errno) + ")";
}

std::string request_locked_memory() {
  // Under a limit, MCL_FUTURE makes some later allocation fail in the middle of a run; whoever may
  // lift the limit does.
  rlimit limit{.rlim_cur = RLIM_INFINITY, .rlim_max = RLIM_INFINITY};
  setrlimit(RLIMIT_MEMLOCK, &limit);
  if (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    return "memory not locked (ulimit -l is " + std::to_string(limit.rlim_cur / 1024) +
           " kB, unlimited is needed)";
  }
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return "memory locked";
  return std::string("memory not locked (") + std::strerror(errno) + ")";
}

}  // namespace

std::string request_realtime() { return request_fifo() + ", " + request_locked_memory(); }

void request_fine_timers() noexcept { prctl(PR_SET_TIMERSLACK, 1UL); }

}  // namespace stillframe::controller
