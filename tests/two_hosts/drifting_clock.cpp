#include <dlfcn.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <ctime>

// To be preloaded: CLOCK_MONOTONIC of a host whose crystal is off by CLOCK_PPM. It agrees with the
// real one at the boot of the time namespace.
namespace {

constexpr std::int64_t second = 1'000'000'000;

double rate() noexcept {
  static const double rate = [] {
    const char* ppm = std::getenv("CLOCK_PPM");
    return 1 + (ppm == nullptr ? 0 : std::atof(ppm)) * 1e-6;
  }();
  return rate;
}

std::int64_t real_ns() noexcept {
  timespec now{};
  syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &now);
  return now.tv_sec * second + now.tv_nsec;
}

/// Only the difference is rounded: a double has no ns left of a clock that has run for months.
std::int64_t drifted(std::int64_t ns, double part) noexcept {
  return ns + std::llround(static_cast<double>(ns) * part);
}

timespec spec(std::int64_t ns) noexcept { return {.tv_sec = ns / second, .tv_nsec = ns % second}; }

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* now) noexcept {
  if (clock != CLOCK_MONOTONIC) return static_cast<int>(syscall(SYS_clock_gettime, clock, now));
  *now = spec(drifted(real_ns(), rate() - 1));
  return 0;
}

int clock_nanosleep(clockid_t clock, int flags, const timespec* until, timespec* left) {
  timespec real = *until;
  if (clock == CLOCK_MONOTONIC && (flags & TIMER_ABSTIME) != 0) {
    real = spec(drifted(until->tv_sec * second + until->tv_nsec, 1 / rate() - 1));
  }
  return syscall(SYS_clock_nanosleep, clock, flags, &real, left) == 0 ? 0 : errno;
}
}
