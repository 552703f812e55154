#pragma once

#include "core/mechanics/elements/element.hpp"

namespace stillframe {

/// Planar beam in the x-y plane (deck, section 2): three deformations, all in m,
///   e_1 = l - l_0            elongation
///   e_2 = -(R_p n_y) . l     bending at p
///   e_3 =  (R_q n_y) . l     bending at q
/// Local coordinates: translation p (3), angle p, translation q (3), angle q.
class PlanarBeam final : public Element {
 public:
  /// l_0_vector: from p to q in the scene as written, m, z = 0. Errors: std::invalid_argument if
  /// its length is not positive.
  PlanarBeam(Eigen::Index node_p, Eigen::Index node_q, const Eigen::Vector3d& l_0_vector);

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
  Eigen::Vector3d n_y_;
};

}  // namespace stillframe
