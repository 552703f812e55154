#pragma once

#include <Eigen/Core>
#include <cmath>

namespace stillframe {

/// z x a: a vector of the x-y plane turned by a quarter.
inline Eigen::Vector3d quarter_turned(const Eigen::Vector3d& a) {
  return Eigen::Vector3d(-a.y(), a.x(), 0);
}

/// R(phi) a about z, by a small difference: (R - I) a, exact for picoradians.
inline Eigen::Vector3d turned_by(double phi, const Eigen::Vector3d& a) {
  const double half = std::sin(0.5 * phi);
  return -2.0 * half * half * a + std::sin(phi) * quarter_turned(a);
}

}  // namespace stillframe
