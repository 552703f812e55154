#pragma once

#include "core/mechanics/elements/element.hpp"

namespace stillframe {

/// A flexible body between any number of interface nodes with position and rotation, and of modes
/// between them. Its frame is that of its first node; the deformations are, of every other node k,
///   e_1..3 = R_1^T (s_k + u_k - u_1) - s_k     displacement in the frame, m
///   e_4..6 = 2 Lambda(lambda_1) lambda_k       2 sin(angle / 2) about its axis, in the frame, rad
/// and behind them the amplitudes of the modes, m. s_k leads from the first node to k in the scene
/// as written. Any rigid motion, of any size, leaves all of them 0. Local coordinates: translation
/// (3) and rotation (4) of each interface node, then those of the nodes whose translations are
/// amplitudes of modes, three a node.
class Superelement final : public Element {
 public:
  /// s: 3 x n, m, of which column 0 is 0; nodes: n of them. mode_nodes: enough for n_modes. Errors:
  /// std::invalid_argument if there is no deformation, or more than max_deformations or max_local.
  Superelement(const std::vector<Eigen::Index>& nodes, const Eigen::Matrix3Xd& s,
               const std::vector<Eigen::Index>& mode_nodes, Eigen::Index n_modes);

  void deformations(const LocalVector& u, LocalDeformation& e) const noexcept override;
  void jacobian(const LocalVector& u, JacobianOut d_e_d_u) const noexcept override;
  void second_derivative(const LocalVector& u, const LocalVector& v, const LocalVector& w,
                         LocalDeformation& result) const noexcept override;
  void jacobian_rates(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                      JacobianOut rate, JacobianOut second_rate) const noexcept override;
  void hessian(const LocalVector& u, const LocalDeformation& sigma,
               LocalHessian& result) const noexcept override;

  Eigen::Index n_nodes() const { return s_.cols(); }
  Eigen::Index n_modes() const { return n_deformations() - 6 * (n_nodes() - 1); }

 private:
  Eigen::Matrix3Xd s_;
};

}  // namespace stillframe
