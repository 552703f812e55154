#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>

#include "msgs/big_endian.hpp"

namespace stillframe {

/// A number that no other process has, nor any log of one: above 0, exact in a double (of two
/// processes of one boot, one pair in 500 million has the same). Its upper part names the clock
/// that the process reads, CLOCK_MONOTONIC of this system since it booted (and of this time
/// namespace). Set-up.
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

/// Who of two processes began first, by what each says of itself; of two that began at one instant
/// the one with the smaller number. Of two clocks the ages are compared, and count as the
/// same within 2 s and a thousandth. Both sides come to one answer, but
/// where the difference is within what the network takes of that bound. Each counts the other as
/// younger by that, so that there both stay and never do both leave: the plant obeys one, and
/// the bound, which grows by a ms a second, passes by within 2000 times what the two ways take. Who
/// is to leave there as well would have to be agreed upon: whatever each side decides alone has an
/// edge, and one where both leave.
struct Beginning {
  std::int64_t instance = 0;
  std::int64_t began_ns = 0, now_ns = 0;  ///< by its own clock: its beginning, and when it said so
};
inline bool began_first(const Beginning& one, const Beginning& other) noexcept {
  if (on_one_clock(one.instance, other.instance)) {
    return one.began_ns != other.began_ns ? one.began_ns < other.began_ns
                                          : one.instance < other.instance;
  }
  const double age = static_cast<double>(one.now_ns) - static_cast<double>(one.began_ns);
  const double other_age = static_cast<double>(other.now_ns) - static_cast<double>(other.began_ns);
  if (std::abs(age - other_age) > 2e9 + 1e-3 * std::max(age, other_age)) return age > other_age;
  return one.instance < other.instance;
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
