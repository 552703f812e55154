#pragma once

#include <algorithm>

namespace stillframe {

/// s(p) = p^3 (10 - 15 p + 6 p^2), which leads from 0 to 1 with velocity and acceleration zero at
/// both ends; p is taken into [0, 1]. Hot: noexcept, no allocation.
inline double smooth_step(double p) noexcept {
  p = std::clamp(p, 0.0, 1.0);
  return p * p * p * (10 + p * (6 * p - 15));
}

/// The p with s(p) = w, w in [0, 1], to the last bit or two. Hot: noexcept, no allocation.
inline double smooth_step_inverse(double w) noexcept {
  double low = 0, high = 1;
  for (int i = 0; i < 54; ++i) {
    const double middle = (low + high) / 2;
    (smooth_step(middle) < w ? low : high) = middle;
  }
  return high;
}

}  // namespace stillframe
