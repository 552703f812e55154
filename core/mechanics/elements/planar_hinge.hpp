#pragma once

#include "core/mechanics/elements/element.hpp"

namespace stillframe {

/// Planar hinge between two nodes at one position: one deformation, the relative rotation
/// e_1 = phi_q - phi_p, rad. Local coordinates: angle p, angle q.
class PlanarHinge final : public Element {
 public:
  PlanarHinge(Eigen::Index node_p, Eigen::Index node_q)
      : Element({angle_of(node_p), angle_of(node_q)}, 1) {}

  void deformations(const LocalVector& u, LocalDeformation& e) const noexcept override {
    e(0) = u(1) - u(0);
  }
  void jacobian(const LocalVector&, JacobianOut d_e_d_u) const noexcept override {
    d_e_d_u << -1.0, 1.0;
  }
  void second_derivative(const LocalVector&, const LocalVector&, const LocalVector&,
                         LocalDeformation& result) const noexcept override {
    result.setZero();
  }
  void jacobian_rates(const LocalVector&, const LocalVector&, const LocalVector&, JacobianOut rate,
                      JacobianOut second_rate) const noexcept override {
    rate.setZero();
    second_rate.setZero();
  }
  void hessian(const LocalVector&, const LocalDeformation&,
               LocalHessian& result) const noexcept override {
    result.setZero();
  }
};

}  // namespace stillframe
