// Preloaded into a process, it makes every clock that can be set jump by an hour, to and fro, at
// each look. CLOCK_MONOTONIC cannot be set, and stays what it is.
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <atomic>

namespace {

time_t step() {
  static std::atomic<unsigned> n = 0;
  return n++ % 2 == 0 ? 3600 : -3600;
}

bool can_be_set(clockid_t clock) {
  return clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE || clock == CLOCK_TAI;
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* now) noexcept {
  const auto result = static_cast<int>(syscall(SYS_clock_gettime, clock, now));
  if (result == 0 && can_be_set(clock)) now->tv_sec += step();
  return result;
}

int gettimeofday(timeval* now, void*) noexcept {
  timespec time{};
  clock_gettime(CLOCK_REALTIME, &time);
  now->tv_sec = time.tv_sec;
  now->tv_usec = time.tv_nsec / 1000;
  return 0;
}

time_t time(time_t* now) noexcept {
  timespec stepped{};
  clock_gettime(CLOCK_REALTIME, &stepped);
  if (now != nullptr) *now = stepped.tv_sec;
  return stepped.tv_sec;
}
}
