#include "controller/realtime.hpp"

#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <thread>

namespace stillframe::controller {

namespace {

// The thread sanitizer alone keeps some 0.7 MB on each stack.
constexpr std::size_t stack_size = 2048 * 1024, stack_touched = 128 * 1024;

void join(RealtimeReport& all, const RealtimeReport& part) {
  all.complete = all.complete && part.complete;
  all.text += (all.text.empty() ? "" : ", ") + part.text;
}

RealtimeReport failed(const std::string& what) {
  return {false, what + " (" + std::strerror(errno) + ")"};
}

RealtimeReport request_fifo(std::int64_t priority) {
  const sched_param parameters{.sched_priority = static_cast<int>(priority)};
  if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters)) {
    errno = error;
    return failed("no SCHED_FIFO");
  }
  return {true, "SCHED_FIFO priority " + std::to_string(priority)};
}

RealtimeReport request_cpu(std::int64_t cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(cpu), &set);
  if (const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set)) {
    errno = error;
    return failed("not on processor " + std::to_string(cpu));
  }
  return {true, "processor " + std::to_string(cpu)};
}

// True if locked memory may grow beyond RLIMIT_MEMLOCK: an address range larger than it, which
// MCL_FUTURE locks as well, can be had.
bool limit_does_not_bind(rlim_t limit) {
  if (limit == RLIM_INFINITY) return true;
  const std::size_t size = limit + 4096;
  void* range = mmap(nullptr, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (range == MAP_FAILED) return false;
  munmap(range, size);
  return true;
}

RealtimeReport request_locked_memory() {
  // Under a limit that binds, MCL_FUTURE makes some later allocation fail in the middle of a run;
  // whoever may lift the limit does.
  rlimit limit{.rlim_cur = RLIM_INFINITY, .rlim_max = RLIM_INFINITY};
  setrlimit(RLIMIT_MEMLOCK, &limit);
  getrlimit(RLIMIT_MEMLOCK, &limit);
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) return failed("memory not locked");
  if (!limit_does_not_bind(limit.rlim_cur)) {
    munlockall();
    return {false, "memory not locked (ulimit -l is " + std::to_string(limit.rlim_cur / 1024) +
                       " kB, unlimited is needed)"};
  }
  // What is freed stays ours: given back, it would fault when it is needed again.
  mallopt(M_TRIM_THRESHOLD, -1);
  mallopt(M_MMAP_MAX, 0);
  return {true, "memory locked"};
}

// Locked memory makes every stack real; the default of 8 MB a thread is for nothing.
void use_small_stacks() {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, stack_size);
  pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

// Held open until the process ends, the file keeps the processors out of states from which they
// wake slowly. Not every machine has it, and where it is missing nothing is lost but that.
std::string keep_processors_awake() {
  const int file = open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
  const std::int32_t longest_us = 0;
  if (file >= 0 && write(file, &longest_us, sizeof longest_us) == sizeof longest_us) {
    return "processors kept awake";
  }
  return "processors may sleep deeply (/dev/cpu_dma_latency cannot be written)";
}

[[gnu::noinline]] void touch_stack() noexcept {
  volatile unsigned char stack[stack_touched];
  for (std::size_t i = 0; i < sizeof stack; i += 1024) stack[i] = 0;
}

}  // namespace

RealtimeReport prepare_process(const Policy& policy) {
  if (policy.realtime == Policy::Realtime::off) return {true, "not asked for"};
  use_small_stacks();
  RealtimeReport report;
  std::thread([&] { report = prepare_thread(policy.priority, policy.cpu); }).join();
  join(report, request_locked_memory());
  report.text += ", " + keep_processors_awake();
  return report;
}

RealtimeReport prepare_thread(std::int64_t priority, std::optional<std::int64_t> cpu) {
  RealtimeReport report = request_fifo(priority);
  if (cpu) join(report, request_cpu(*cpu));
  join(report, {prctl(PR_SET_TIMERSLACK, 1UL) == 0, "timer slack 1 ns"});
  touch_stack();
  return report;
}

void prepare_servant(const Policy& policy) noexcept {
  if (policy.realtime != Policy::Realtime::off) prepare_thread(policy.priority - 1, {});
}

}  // namespace stillframe::controller
