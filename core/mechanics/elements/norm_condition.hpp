#pragma once

#include "core/mechanics/elements/element.hpp"

namespace stillframe {

/// The condition that the Euler parameters of a rotation node have norm one, as an element with one
/// deformation e = (lambda^T lambda - 1) / 2 = delta_0 + delta^T delta / 2, always zero.
/// Dimensionless.
class NormCondition final : public Element {
 public:
  explicit NormCondition(Eigen::Index node) : Element({rotation_of(node)}, 1) {}

  void deformations(const LocalVector& u, LocalDeformation& e) const noexcept override {
    e(0) = u(0) + 0.5 * u.squaredNorm();
  }
  void jacobian(const LocalVector& u, JacobianOut d_e_d_u) const noexcept override {
    d_e_d_u = u.transpose();
    d_e_d_u(0, 0) += 1.0;
  }
  void second_derivative(const LocalVector&, const LocalVector& v, const LocalVector& w,
                         LocalDeformation& result) const noexcept override {
    result(0) = v.dot(w);
  }
  void jacobian_rates(const LocalVector&, const LocalVector& v, const LocalVector& a,
                      JacobianOut rate, JacobianOut second_rate) const noexcept override {
    rate = v.transpose();
    second_rate = a.transpose();
  }
  void hessian(const LocalVector&, const LocalDeformation& sigma,
               LocalHessian& result) const noexcept override {
    result.setZero();
    result.diagonal().setConstant(sigma(0));
  }
};

}  // namespace stillframe
