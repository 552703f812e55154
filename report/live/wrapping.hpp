#pragma once

#include <cstdint>

namespace stillframe::live {

// Numbers from the bus may be anything: what does not fit wraps around instead of being undefined.
// Hot: noexcept, no allocation.
inline std::int64_t wrapping_sum(std::int64_t a, std::int64_t b) noexcept {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
}
inline std::int64_t wrapping_difference(std::int64_t a, std::int64_t b) noexcept {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}

}  // namespace stillframe::live
