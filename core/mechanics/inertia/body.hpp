#pragma once

#include "core/mechanics/elements/rotation.hpp"
#include "core/mechanics/inertia/inertia.hpp"

namespace stillframe {

/// Inertia forces dual to Euler parameters of body rates omega = 2 Lambda(lambda) lambda':
/// Lagrange's equations of omega^T J omega / 2 are
///   F = 2 Lambda^T J omega' + 4 Lambda(lambda')^T J omega, omega' = 2 Lambda lambda''.
/// p = J omega and its rate p' = J omega' may come from several nodes.
inline Vector4 rate_force(const Vector4& lambda, const Vector4& v, const Vector3& p,
                          const Vector3& p_rate) noexcept {
  return 2.0 * body_rate_matrix(lambda).transpose() * p_rate +
         4.0 * body_rate_matrix(v).transpose() * p;
}

/// A rotating body: its inertia J (3 x 3, kg m^2) in axes fixed to it, those of the scene as
/// written, at the rotation of a node.
class Body final : public Inertia {
 public:
  Body(Eigen::Index node, const Eigen::Matrix3d& J) : Inertia({rotation_of(node)}), J_(J) {}

  void mass(const LocalVector& u, LocalHessian& M) const noexcept override {
    const auto L = body_rate_matrix(euler_parameters(u));
    M = 4.0 * L.transpose() * J_ * L;
  }
  void force(const LocalVector& u, const LocalVector& v, const LocalVector& a,
             const Eigen::Vector3d&, LocalVector& F) const noexcept override {
    const Vector4 lambda = euler_parameters(u);
    const auto L = body_rate_matrix(lambda);
    F = rate_force(lambda, v, J_ * (2.0 * (L * v)), J_ * (2.0 * (L * a)));
  }
  void tangents(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                const Eigen::Vector3d&, LocalHessian& d_F_d_v,
                LocalHessian& d_F_d_u) const noexcept override {
    const Vector4 rate = v, acceleration = a;
    const auto L = body_rate_matrix(euler_parameters(u));
    const auto L_v = body_rate_matrix(rate), L_a = body_rate_matrix(acceleration);
    const Vector3 p = J_ * (2.0 * (L * rate)), p_rate = J_ * (2.0 * (L * acceleration));
    // omega = -2 Lambda(lambda') lambda and omega' = -2 Lambda(lambda'') lambda.
    d_F_d_v = 4.0 * d_body_rate_dual(p) + 8.0 * L_v.transpose() * J_ * L;
    d_F_d_u = 2.0 * d_body_rate_dual(p_rate) - 4.0 * L.transpose() * J_ * L_a -
              8.0 * L_v.transpose() * J_ * L_v;
  }
  double gravity_energy(const LocalVector&, const Eigen::Vector3d&) const noexcept override {
    return 0;
  }

 private:
  Eigen::Matrix3d J_;
};

}  // namespace stillframe
