#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace stillframe::judge {

/// What is left of a direction across others, which are orthonormal; nothing of one that they span.
inline Eigen::Vector3d across(Eigen::Vector3d direction,
                              const std::vector<Eigen::Vector3d>& others) {
  for (const Eigen::Vector3d& other : others) direction -= other.dot(direction) * other;
  // Directions of a scene are written in a few digits.
  return direction.norm() > 1e-6 ? direction.normalized() : Eigen::Vector3d::Zero();
}

/// Adds it to an orthonormal basis, if it is not within.
inline void add_to(std::vector<Eigen::Vector3d>& basis, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d rest = across(direction, basis);
  if (!rest.isZero(0)) basis.push_back(rest);
}

}  // namespace stillframe::judge
