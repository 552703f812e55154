#pragma once

#include "core/mechanics/elements/element.hpp"

namespace stillframe {

/// Spatial beam between two nodes with position and rotation: six deformations, all of length unit
/// (m),
///   e_1 = l - l_0                                          elongation
///   e_2 = l_0 (R_p n_z . R_q n_y - R_p n_y . R_q n_z) / 2  torsion
///   e_3 = -R_p n_z . l,  e_4 = R_q n_z . l                 bending in the n_x-n_z plane
///   e_5 =  R_p n_y . l,  e_6 = -R_q n_y . l                bending in the n_x-n_y plane
/// with n_x along the undeformed beam (deck, section 2, in three dimensions). A rigid beam has all
/// six zero. Local coordinates: translation p (3), rotation p (4), translation q (3), rotation q
/// (4).
class Beam final : public Element {
 public:
  /// l_0_vector: from p to q in the scene as written, m; orientation: a vector that spans the
  /// n_x-n_y plane with it. Errors: std::invalid_argument if the length is not positive or the two
  /// are parallel.
  Beam(Eigen::Index node_p, Eigen::Index node_q, const Eigen::Vector3d& l_0_vector,
       const Eigen::Vector3d& orientation);

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
  Eigen::Vector3d n_y_, n_z_;
};

/// An orientation for a rigid beam, for which any is as good as another.
Eigen::Vector3d any_orientation(const Eigen::Vector3d& l_0_vector);

}  // namespace stillframe
