#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "tests/core/hyper_dual.hpp"

// The deformation functions once more, as the definitions say them and over any scalar: plain
// differences of lengths and full rotation matrices, with none of the rearrangement that
// core/mechanics/elements needs for its digits.
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

/// n turned about z.
template <class T>
Triple<T> turn(const T& angle, const Triple<T>& n) {
  const T c = cosine(angle), s = sine(angle);
  return {c * n[0] - s * n[1], s * n[0] + c * n[1], n[2]};
}

/// l_0 + u_q - u_p, where the translations start at p and q in u.
template <class T>
Triple<T> span(const Eigen::Vector3d& l_0, const std::vector<T>& u, size_t p, size_t q) {
  const Triple<T> start = constant<T>(l_0);
  return {start[0] + (u[q] - u[p]), start[1] + (u[q + 1] - u[p + 1]),
          start[2] + (u[q + 2] - u[p + 2])};
}

template <class T>
T elongation(const Eigen::Vector3d& l_0, const Triple<T>& l) {
  const Triple<T> start = constant<T>(l_0);
  return square_root(dot(l, l)) - square_root(dot(start, start));
}

template <class T>
std::vector<T> truss_formula(const Eigen::Vector3d& l_0, const std::vector<T>& u) {
  return {elongation(l_0, span(l_0, u, 0, 3))};
}

/// R(lambda) a - a, where the displacements of lambda start at i in u.
template <class T>
Triple<T> turned_by(const std::vector<T>& u, size_t i, const Eigen::Vector3d& arm) {
  const T lambda[4] = {T(1.0) + u[i], u[i + 1], u[i + 2], u[i + 3]};
  const Triple<T> start = constant<T>(arm), end = rotate(lambda, start);
  return {end[0] - start[0], end[1] - start[1], end[2] - start[2]};
}

/// A truss from the end of one arm to the end of another; u has no rotation where an arm is zero.
template <class T>
std::vector<T> arm_truss_formula(const Eigen::Vector3d& l_0, const Eigen::Vector3d& arm_p,
                                 const Eigen::Vector3d& arm_q, const std::vector<T>& u) {
  const size_t q = arm_p.isZero(0) ? 3 : 7;
  Triple<T> l = span(l_0, u, 0, q);
  const auto add = [&l](const Triple<T>& turned, const T& sign) {
    for (size_t i = 0; i < 3; ++i) l[i] = l[i] + sign * turned[i];
  };
  if (!arm_p.isZero(0)) add(turned_by(u, 3, arm_p), T(-1.0));
  if (!arm_q.isZero(0)) add(turned_by(u, q + 3, arm_q), T(1.0));
  return {elongation(l_0, l)};
}

// What is subtracted below from the products of axes is zero in exact numbers; it takes out the
// rounding of the axes themselves.

template <class T>
std::vector<T> beam_formula(const Eigen::Vector3d& l_0, const Eigen::Vector3d& orientation,
                            const std::vector<T>& u) {
  const Eigen::Vector3d n_x = l_0 / l_0.norm(), z = n_x.cross(orientation).normalized(),
                        y = z.cross(n_x);
  const Triple<T> start = constant<T>(l_0), n_y = constant<T>(y), n_z = constant<T>(z);
  const Triple<T> l = span(l_0, u, 0, 7);
  const T one(1.0), half(0.5), zero(0.0);
  const T p[4] = {one + u[3], u[4], u[5], u[6]}, q[4] = {one + u[10], u[11], u[12], u[13]};
  const Triple<T> py = rotate(p, n_y), pz = rotate(p, n_z), qy = rotate(q, n_y),
                  qz = rotate(q, n_z);
  const T y_0 = dot(n_y, start), z_0 = dot(n_z, start);
  return {elongation(l_0, l),
          half * square_root(dot(start, start)) * (dot(pz, qy) - dot(py, qz)),
          zero - (dot(pz, l) - z_0),
          dot(qz, l) - z_0,
          dot(py, l) - y_0,
          zero - (dot(qy, l) - y_0)};
}

template <class T>
std::vector<T> planar_beam_formula(const Eigen::Vector3d& l_0, const std::vector<T>& u) {
  const Eigen::Vector3d n_x = l_0 / l_0.norm();
  const Triple<T> n_y = constant<T>(Eigen::Vector3d::UnitZ().cross(n_x)), l = span(l_0, u, 0, 4);
  const T y_0 = dot(n_y, constant<T>(l_0)), zero(0.0);
  return {elongation(l_0, l), zero - (dot(turn(u[3], n_y), l) - y_0),
          dot(turn(u[7], n_y), l) - y_0};
}

template <class T>
std::vector<T> hinge_formula(const Eigen::Vector3d& axis, const std::vector<T>& u) {
  const Eigen::Vector3d x = axis.normalized(), y = x.unitOrthogonal(), z = x.cross(y);
  const Triple<T> n_x = constant<T>(x), n_y = constant<T>(y), n_z = constant<T>(z);
  const T one(1.0), zero(0.0), two(2.0);
  const T p[4] = {one + u[0], u[1], u[2], u[3]}, q[4] = {one + u[4], u[5], u[6], u[7]};
  // Quaternion product conj(p) q, entry by entry.
  const T mu_0 = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3];
  const Triple<T> mu = {p[0] * q[1] - p[1] * q[0] - p[2] * q[3] + p[3] * q[2],
                        p[0] * q[2] - p[2] * q[0] - p[3] * q[1] + p[1] * q[3],
                        p[0] * q[3] - p[3] * q[0] - p[1] * q[2] + p[2] * q[1]};
  const Triple<T> qx = rotate(q, n_x);
  return {two * arc_tangent(dot(mu, n_x), mu_0), zero - (dot(rotate(p, n_z), qx) - dot(n_z, n_x)),
          dot(rotate(p, n_y), qx) - dot(n_y, n_x)};
}

/// A superelement of two interfaces without modes: s is from the first to the second.
template <class T>
std::vector<T> superelement_formula(const Eigen::Vector3d& s, const std::vector<T>& u) {
  const T one(1.0), two(2.0);
  const T p[4] = {one + u[3], u[4], u[5], u[6]}, q[4] = {one + u[10], u[11], u[12], u[13]};
  const Triple<T> start = constant<T>(s), l = span(s, u, 0, 7);
  std::vector<T> e;
  for (int i = 0; i < 3; ++i) {
    const Triple<T> n = constant<T>(Eigen::Vector3d::Unit(i));
    e.push_back(dot(rotate(p, n), l) - dot(n, start));
  }
  // Quaternion product conj(p) q, entry by entry.
  e.push_back(two * (p[0] * q[1] - p[1] * q[0] - p[2] * q[3] + p[3] * q[2]));
  e.push_back(two * (p[0] * q[2] - p[2] * q[0] - p[3] * q[1] + p[1] * q[3]));
  e.push_back(two * (p[0] * q[3] - p[3] * q[0] - p[1] * q[2] + p[2] * q[1]));
  return e;
}

/// The chord's shortening (2 a^2 + a b + 2 b^2) / (30 l_0) of what bends by a and b.
template <class T>
T arc_shortening(const T& a, const T& b, const T& l) {
  const T two(2.0);
  return (two * a * a + a * b + two * b * b) / (T(30.0) * l);
}

/// The deformations of the arc of a planar (3) or spatial beam (6) from those of its chord.
template <class T>
std::vector<T> arc_formula(const Eigen::Vector3d& l_0, const std::vector<T>& c) {
  const Triple<T> start = constant<T>(l_0);
  const T l = square_root(dot(start, start));
  if (c.size() == 3) return {c[0] + arc_shortening(c[1], c[2], l), c[1], c[2]};
  const T in_z = c[1] * (c[2] + c[3]) / (T(6.0) * l), in_y = c[1] * (c[4] + c[5]) / (T(6.0) * l);
  return {c[0] + arc_shortening(c[2], c[3], l) + arc_shortening(c[4], c[5], l),
          c[1] + (c[3] * c[4] - c[2] * c[5]) / l,
          c[2] + in_y,
          c[3] - in_y,
          c[4] - in_z,
          c[5] + in_z};
}

/// c_i + c^T Q_i c / 2.
template <class T, class Matrices>
std::vector<T> with_quadratic_terms(const Matrices& Q, const std::vector<T>& c) {
  std::vector<T> e = c;
  for (size_t i = 0; i < c.size(); ++i) {
    for (size_t j = 0; j < c.size(); ++j) {
      for (size_t k = 0; k < c.size(); ++k) {
        e[i] = e[i] + T(0.5 * Q[i](static_cast<int>(j), static_cast<int>(k))) * c[j] * c[k];
      }
    }
  }
  return e;
}

template <class T>
std::vector<T> norm_formula(const std::vector<T>& u) {
  const T w = T(1.0) + u[0];
  return {T(0.5) * (w * w + u[1] * u[1] + u[2] * u[2] + u[3] * u[3] - T(1.0))};
}

}  // namespace stillframe::test
