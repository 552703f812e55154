#pragma once

#include <algorithm>
#include <cstdint>

// What of the numbers in seconds holds for loops below 200 Hz. Source: docs/safety.md, slow loops.
namespace stillframe::controller {

/// A time (s) of the fault policy, which is meant for loops of 200 Hz and more: a slower one takes
/// as many samples as one of 200 Hz, because its frame and its floor are as much slower.
constexpr double slowed(double seconds, double sample_rate_hz) noexcept {
  constexpr double rate_hz = 200;
  return seconds * std::max(1.0, rate_hz / sample_rate_hz);
}

/// Who waits for amplifiers that hold a force for ten samples allows them half as many again.
inline constexpr std::int64_t amplifiers_hold = 15;
/// s, in which they then let go of it.
inline constexpr double amplifiers_fade_s = 1;

}  // namespace stillframe::controller
