#pragma once

#include <cstdint>
#include <ctime>

namespace stillframe::controller {

inline constexpr std::int64_t ns_per_s = 1'000'000'000;

/// CLOCK_MONOTONIC in ns, the clock that plant and controller share. Hot: noexcept, no allocation.
inline std::int64_t monotonic_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * ns_per_s + now.tv_nsec;
}

}  // namespace stillframe::controller
