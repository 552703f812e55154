#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

// Rotations by Euler parameters lambda = (lambda_0, v), lambda^T lambda = 1. A rotation node stores
// the displacement delta = lambda - (1, 0, 0, 0), so that small rotations keep all their digits.
namespace stillframe {

using Vector3 = Eigen::Vector3d;
using Vector4 = Eigen::Vector4d;

inline Eigen::Matrix3d cross_matrix(const Vector3& a) {
  Eigen::Matrix3d matrix;
  matrix << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return matrix;
}

/// Euler parameters (4) from the displacement of a rotation node (4).
inline Vector4 euler_parameters(const Vector4& delta) {
  return Vector4(1.0 + delta(0), delta(1), delta(2), delta(3));
}

/// The symmetric bilinear form B(a, b) n with (R(lambda) - I) n = B(lambda, lambda) n, where
/// R(lambda) - I = 2 lambda_0 [v]x + 2 [v]x [v]x. Being quadratic in lambda, R has the derivatives
/// dR(d) n = 2 B(lambda, d) n and d2R(d, w) n = 2 B(d, w) n, and none above.
// Always: in a batch of files GCC leaves it out of line, which is an eighth of a step of the plant.
[[gnu::always_inline]] inline Vector3 rotation_form(const Vector4& a, const Vector4& b,
                                                    const Vector3& n) {
  const Vector3 av = a.tail<3>(), bv = b.tail<3>();
  return (a(0) * bv + b(0) * av).cross(n) + av.cross(bv.cross(n)) + bv.cross(av.cross(n));
}

/// d(R n)/d lambda, 3 x 4.
inline Eigen::Matrix<double, 3, 4> d_rotated_d_lambda(const Vector4& lambda, const Vector3& n) {
  const Vector3 v = lambda.tail<3>(), vn = v.cross(n);
  Eigen::Matrix<double, 3, 4> derivative;
  derivative.col(0) = 2.0 * vn;
  const Eigen::Matrix3d N = cross_matrix(n);
  derivative.rightCols<3>() = -2.0 * (lambda(0) * N + cross_matrix(vn) + cross_matrix(v) * N);
  return derivative;
}

/// Second derivative of h . (R n) to lambda, 4 x 4 and constant: entry (i, j) is 2 h . B(e_i, e_j)
/// n.
inline Eigen::Matrix4d rotated_hessian(const Vector3& h, const Vector3& n) {
  Eigen::Matrix4d hessian = Eigen::Matrix4d::Zero();
  const Vector3 mixed = 2.0 * n.cross(h);
  hessian.block<1, 3>(0, 1) = mixed.transpose();
  hessian.block<3, 1>(1, 0) = mixed;
  hessian.bottomRightCorner<3, 3>() = 2.0 * (h * n.transpose() + n * h.transpose());
  hessian.bottomRightCorner<3, 3>().diagonal().array() -= 4.0 * h.dot(n);
  return hessian;
}

/// A body-fixed axis n turned by R(lambda), with d(R n)/d lambda, and the first and second time
/// derivatives of both while lambda' = v and lambda'' = a.
struct TurningAxis {
  Vector3 value[3];
  Eigen::Matrix<double, 3, 4> derivative[3];
  TurningAxis(const Vector4& lambda, const Vector4& v, const Vector4& a, const Vector3& n)
      : value{n + rotation_form(lambda, lambda, n), 2.0 * rotation_form(lambda, v, n),
              2.0 * (rotation_form(v, v, n) + rotation_form(lambda, a, n))},
        derivative{d_rotated_d_lambda(lambda, n), d_rotated_d_lambda(v, n),
                   d_rotated_d_lambda(a, n)} {}
};

/// omega_body = 2 Lambda(lambda) d(lambda)/dt, 3 x 4.
inline Eigen::Matrix<double, 3, 4> body_rate_matrix(const Vector4& lambda) {
  Eigen::Matrix<double, 3, 4> matrix;
  matrix.col(0) = -lambda.tail<3>();
  matrix.rightCols<3>() = -cross_matrix(lambda.tail<3>());
  matrix.rightCols<3>().diagonal().array() += lambda(0);
  return matrix;
}

/// omega_space = 2 Lambda_s(lambda) d(lambda)/dt, 3 x 4.
inline Eigen::Matrix<double, 3, 4> space_rate_matrix(const Vector4& lambda) {
  Eigen::Matrix<double, 3, 4> matrix;
  matrix.col(0) = -lambda.tail<3>();
  matrix.rightCols<3>() = cross_matrix(lambda.tail<3>());
  matrix.rightCols<3>().diagonal().array() += lambda(0);
  return matrix;
}

/// d(Lambda(lambda)^T p)/d lambda for a constant p, 4 x 4, and the same of Lambda_s.
inline Eigen::Matrix4d d_body_rate_dual(const Vector3& p) {
  Eigen::Matrix4d matrix;
  matrix << 0, -p.transpose(), p, -cross_matrix(p);
  return matrix;
}
inline Eigen::Matrix4d d_space_rate_dual(const Vector3& p) {
  Eigen::Matrix4d matrix;
  matrix << 0, -p.transpose(), p, cross_matrix(p);
  return matrix;
}

}  // namespace stillframe
