#pragma once

#include <cstdint>
#include <span>

struct sock_filter;

namespace stillframe {

/// The largest message that a datagram may claim to be a part of, bytes: scene, floor and gains of
/// a run_info take some hundred thousand.
inline constexpr std::uint32_t largest_message = 1u << 24;

/// What the kernel lets through to liblcm's socket, as a classic BPF program: whole messages of the
/// channels of msgs/channels.hpp, and fragments whose offset, size and numbers fit each other.
/// liblcm 1.3.1 believes every length in a fragment and any channel without an end, and keeps a
/// table entry for every name that it has ever heard.
std::span<const sock_filter> lcm_guard();

/// Gives the guard to a UDP socket; false if the system refuses. Set-up.
bool attach_lcm_guard(int socket) noexcept;

/// Whether every UDP socket of this process that is bound gets the guard before it is: liblcm opens
/// its socket by itself and reads it at once, so this program has a bind() of its own.
bool lcm_is_guarded() noexcept;

}  // namespace stillframe
