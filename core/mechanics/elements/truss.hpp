#pragma once

#include "core/mechanics/elements/element.hpp"

namespace stillframe {

/// Spatial truss between two translational nodes: one deformation, the elongation e_1 = l - l_0 in
/// m.
class Truss final : public Element {
 public:
  /// l_0_vector: from node p to node q in the scene as written, m. Errors: std::invalid_argument if
  /// its length is not positive.
  Truss(Eigen::Index node_p, Eigen::Index node_q, const Eigen::Vector3d& l_0_vector);

  void deformations(const LocalVector& u, LocalDeformation& e) const noexcept override;
  void jacobian(const LocalVector& u, JacobianOut d_e_d_u) const noexcept override;
  void second_derivative(const LocalVector& u, const LocalVector& v, const LocalVector& w,
                         LocalDeformation& result) const noexcept override;
  void jacobian_rates(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                      JacobianOut rate, JacobianOut second_rate) const noexcept override;
  void hessian(const LocalVector& u, const LocalDeformation& sigma,
               LocalHessian& result) const noexcept override;

 private:
  Eigen::Vector3d l_0_vector_;
  double l_0_;
};

}  // namespace stillframe
