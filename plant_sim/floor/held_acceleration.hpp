#pragma once

#include <Eigen/Core>

namespace stillframe::floor {

/// The acceleration that, held over each sample, leads through a given course of positions without
/// any drift.
///   a[k] = (d[k+1] - 2 d[k] + d[k-1]) / T_s^2
/// Its exact integrals from rest are v[k] = (d[k] - d[k-1]) / T_s and x[k] = (d[k] + d[k-1]) / 2,
/// however long they go on: where d ends, velocity and position end. The double sum telescopes, and
/// so do the rounding errors of d; x is d half a sample late. earlier, present, later: d[k-1],
/// d[k], d[k+1], m or rad. rate: 1 / T_s, 1/s. Hot: noexcept, no allocation.
inline double held_acceleration(double earlier, double present, double later,
                                double rate) noexcept {
  return ((later - present) - (present - earlier)) * (rate * rate);
}

/// The gain of held_acceleration on a sine of position at f, (2 - 2 cos(2 pi f / rate)) rate^2,
/// which is (2 pi f)^2 for frequencies far below the rate. 1/s^2. frequency_hz: Hz; rate: 1/s.
double held_acceleration_gain(double frequency_hz, double rate) noexcept;

/// held_acceleration of a whole course (n) of positions that are zero before it and stay at its
/// last value behind it: n entries.
Eigen::VectorXd held_accelerations(const Eigen::VectorXd& position, double rate);

}  // namespace stillframe::floor
