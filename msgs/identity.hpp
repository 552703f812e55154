#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "msgs/big_endian.hpp"

namespace stillframe {

/// A number that no other process has had, nor any log of one: above 0, exact in a double. Its
/// upper part names the clock that the process reads, CLOCK_MONOTONIC of this system since it
/// booted (and of this time namespace). Set-up.
std::int64_t new_instance();

/// A number for a run, short enough to be typed: above 0, below 1e9. Set-up.
std::int64_t new_run_id();

/// Bits of an instance below those that name its clock.
inline constexpr int bits_below_clock = 29;

/// Whether two processes read the same clock; an instance that names none is taken for one of this
/// system. Of two systems one in 16 million pairs is mistaken for one.
inline bool on_one_clock(std::int64_t instance, std::int64_t other) noexcept {
  const std::int64_t clock = instance >> bits_below_clock, other_clock = other >> bits_below_clock;
  return clock == 0 || other_clock == 0 || clock == other_clock;
}

/// What a measurement or command begins with, behind its fingerprint.
struct Identity {
  std::int64_t run_id = 0, plant_instance = 0;
  std::int64_t controller_instance = 0;  ///< that is obeyed (measurement), that commands (command)
};

/// Reads it without decoding the rest; none if there are not so many bytes. Hot: noexcept, no
/// allocation.
inline std::optional<Identity> identity_of(std::string_view bytes) noexcept {
  if (bytes.size() < 32) return std::nullopt;
  return Identity{read_int64(&bytes[8]), read_int64(&bytes[16]), read_int64(&bytes[24])};
}

}  // namespace stillframe
