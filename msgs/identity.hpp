#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "msgs/big_endian.hpp"
#include "msgs/clock.hpp"

namespace stillframe {

/// A number that no other process has had, nor any log of one: above 0, exact in a double. Set-up.
std::int64_t new_instance();

/// A number for a run, short enough to be typed: above 0, below 1e9. Set-up.
std::int64_t new_run_id();

/// What was sent longer ago is a recording, or has waited where nobody should act on it any more.
/// Four times what a plant takes to say again that it is there, twenty times what a status takes.
inline constexpr std::int64_t fresh_ns = 2 * ns_per_s;

/// Whether a message that says when it was sent (CLOCK_MONOTONIC) was sent just now. Hot: noexcept,
/// no allocation.
inline bool is_fresh(std::int64_t sent_ns, std::int64_t now_ns) noexcept {
  return sent_ns <= now_ns && sent_ns > now_ns - fresh_ns;
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
