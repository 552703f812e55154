#pragma once

#include <cerrno>
#include <cstdint>
#include <ctime>

namespace stillframe {

inline constexpr std::int64_t ns_per_s = 1'000'000'000;

/// CLOCK_MONOTONIC in ns, which all processes of one system share. Hot: noexcept, no allocation.
inline std::int64_t monotonic_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * ns_per_s + now.tv_nsec;
}

/// Sleeps until a time on CLOCK_MONOTONIC, through any signal. Hot: noexcept, no allocation.
inline void sleep_until(std::int64_t time_ns) noexcept {
  const timespec until{.tv_sec = time_ns / ns_per_s, .tv_nsec = time_ns % ns_per_s};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace stillframe
