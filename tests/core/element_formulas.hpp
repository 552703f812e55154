#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "tests/core/hyper_dual.hpp"

// The deformation functions once more, as the definitions say them and over any scalar: plain
// differences of lengths and full rotation matrices, with none of the rearrangement that
// core/elements needs for its digits.
namespace stillframe::test {

template <class T>
using Triple = std::array<T, 3>;

template <class T>
T dot(const Triple<T>& a, const Triple<T>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <class T>
Triple<T> constant(const Eigen::Vector3d& v) {
  return {T(v.x()), T(v.y()), T(v.z())};
}

/// R(lambda) n by the nine entries of the rotation matrix of a quaternion (w, x, y, z).
template <class T>
Triple<T> rotate(const T* lambda, const Triple<T>& n) {
  const T w = lambda[0], x = lambda[1], y = lambda[2], z = lambda[3], one(1.0), two(2.0);
  return {(one - two * (y * y + z * z)) * n[0] + two * (x * y - w * z) * n[1] +
              two * (x * z + w * y) * n[2],
          two * (x * y + w * z) * n[0] + (one - two * (x * x + z * z)) * n[1] +
              two * (y * z - w * x) * n[2],
          two * (x * z - w * y) * n[0] + two * (y * z + w * x) * n[1] +
              (one - two * (x * x + y * y)) * n[2]};
}

template <class T>
std::vector<T> truss_formula(const Eigen::Vector3d& l_0, const std::vector<T>& u) {
  const Triple<T> start = constant<T>(l_0);
  const Triple<T> l = {start[0] + (u[3] - u[0]), start[1] + (u[4] - u[1]),
                       start[2] + (u[5] - u[2])};
  return {square_root(dot(l, l)) - square_root(dot(start, start))};
}

/// n_y is the free choice that core/elements/beam.cpp makes: Eigen's perpendicular of n_x.
template <class T>
std::vector<T> beam_formula(const Eigen::Vector3d& l_0, const std::vector<T>& u) {
  const Eigen::Vector3d n_x = l_0 / l_0.norm(), y = n_x.unitOrthogonal(), z = n_x.cross(y);
  const Triple<T> start = constant<T>(l_0), n_y = constant<T>(y), n_z = constant<T>(z);
  const Triple<T> l = {start[0] + (u[7] - u[0]), start[1] + (u[8] - u[1]),
                       start[2] + (u[9] - u[2])};
  const T one(1.0), half(0.5), zero(0.0);
  const T p[4] = {one + u[3], u[4], u[5], u[6]}, q[4] = {one + u[10], u[11], u[12], u[13]};
  const Triple<T> py = rotate(p, n_y), pz = rotate(p, n_z), qy = rotate(q, n_y),
                  qz = rotate(q, n_z);
  const T length_0 = square_root(dot(start, start));
  // torsion_0, y_0 and z_0 are zero in exact numbers; they take out the rounding of n_y and n_z
  // themselves.
  const T torsion_0 = dot(n_z, n_y) - dot(n_y, n_z), y_0 = dot(n_y, start), z_0 = dot(n_z, start);
  return {square_root(dot(l, l)) - length_0,
          half * length_0 * (dot(pz, qy) - dot(py, qz) - torsion_0),
          zero - (dot(pz, l) - z_0),
          dot(qz, l) - z_0,
          dot(py, l) - y_0,
          zero - (dot(qy, l) - y_0)};
}

template <class T>
std::vector<T> norm_formula(const std::vector<T>& u) {
  const T w = T(1.0) + u[0];
  return {T(0.5) * (w * w + u[1] * u[1] + u[2] * u[2] + u[3] * u[3] - T(1.0))};
}

}  // namespace stillframe::test
