#pragma once

#include <numbers>

namespace stillframe {

/// Radians in a turn: angular frequency over frequency in Hz.
inline constexpr double two_pi = 2 * std::numbers::pi;

}  // namespace stillframe
