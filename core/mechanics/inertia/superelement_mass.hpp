#pragma once

#include "core/mechanics/elements/superelement.hpp"
#include "core/mechanics/inertia/inertia.hpp"

namespace stillframe {

/// Mass of a superelement: T = w^T M w / 2 of the rates w of its interface nodes, each in the frame
/// of that node (R_k^T u_k', 2 Lambda(lambda_k) lambda_k'), and of its modes. Of a rigid motion of
/// any size that is exact; of elastic motion to first order in the deformations, as is the linear
/// theory that M is from. Weight acts at the centre of mass of the deformed body,
///   V = -g . (m u_1 + (R_1 - I) m c + R_1 P e).
class SuperelementMass final : public Inertia {
 public:
  /// M: (6 n + n_modes)^2, symmetric: forces (N) and moments (N m) of translational (m/s^2) and
  /// angular accelerations (rad/s^2) of the interface nodes in turn, and of the modes' amplitudes,
  /// in the axes of the scene as written. Local coordinates: those of the element.
  SuperelementMass(Superelement element, const Eigen::Matrix3Xd& s, const Eigen::MatrixXd& M);

  void mass(const LocalVector& u, LocalHessian& M) const noexcept override;
  void force(const LocalVector& u, const LocalVector& v, const LocalVector& a,
             const Eigen::Vector3d& g, LocalVector& F) const noexcept override;
  void tangents(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                const Eigen::Vector3d& g, LocalHessian& d_F_d_v,
                LocalHessian& d_F_d_u) const noexcept override;
  double gravity_energy(const LocalVector& u, const Eigen::Vector3d& g) const noexcept override;

 private:
  using Block = Eigen::Matrix<double, 6, 7>;
  template <class OfNode>
  LocalHessian times(const OfNode& block, bool modes) const noexcept;
  template <class OfNode>
  void add_transposed(const OfNode& block, bool modes, const LocalHessian& right,
                      LocalHessian& sum) const noexcept;
  LocalDeformation deformations(const LocalVector& u) const noexcept;

  Superelement element_;
  Eigen::MatrixXd M_;
  double m_ = 0;         ///< kg
  Eigen::Vector3d m_c_;  ///< kg m, of the centre of mass from the first node
  Eigen::Matrix3Xd P_;   ///< 3 x n_e, kg: how deformations move it, in the frame
};

/// M of rigid motion (6 x 6) about the first node, in the axes of M.
Eigen::Matrix<double, 6, 6> rigid_mass(const Eigen::Matrix3Xd& s, const Eigen::MatrixXd& M);
/// The motions of interface nodes and modes ((6 n + n_modes) x 6) of a rigid translation and turn
/// about the first node.
Eigen::MatrixXd rigid_motions(const Eigen::Matrix3Xd& s, Eigen::Index n_modes);

}  // namespace stillframe
