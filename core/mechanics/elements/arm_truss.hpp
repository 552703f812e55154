#pragma once

#include "core/mechanics/elements/element.hpp"

namespace stillframe {

/// A truss whose ends are points of rigid bodies: end p is the node p displaced by u_p plus an arm
/// a_p that turns with it, so that the difference of the ends is displaced by
///   d = u_q + (R(lambda_q) - I) a_q - u_p - (R(lambda_p) - I) a_p,
/// and e_1 = |l_0 + d| - |l_0|, m. It stands for a truss between nodes that rigid beams carry, in a
/// quarter of their coordinates. Local coordinates: translation p (3), rotation p (4, if it has an
/// arm), the same of q. Source: deck, section 2, with the rigid beams solved for.
class ArmTruss final : public Element {
 public:
  /// l_0_vector: from end to end in the scene as written, m; a zero arm is none. Errors:
  /// std::invalid_argument if its length is not positive.
  ArmTruss(Eigen::Index node_p, Eigen::Index node_q, const Eigen::Vector3d& l_0_vector,
           const Eigen::Vector3d& arm_p, const Eigen::Vector3d& arm_q);

  void deformations(const LocalVector& u, LocalDeformation& e) const noexcept override;
  void jacobian(const LocalVector& u, JacobianOut d_e_d_u) const noexcept override;
  void second_derivative(const LocalVector& u, const LocalVector& v, const LocalVector& w,
                         LocalDeformation& result) const noexcept override;
  void jacobian_rates(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                      JacobianOut rate, JacobianOut second_rate) const noexcept override;
  void hessian(const LocalVector& u, const LocalDeformation& sigma,
               LocalHessian& result) const noexcept override;

 private:
  /// One end: where its coordinates stand, its arm, and whether it counts plus or minus.
  struct End {
    Eigen::Vector3d arm;
    Eigen::Index at, rotation;  ///< first translation, first Euler parameter or -1
    double sign;
  };
  using Row = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, max_local>;

  Eigen::Vector3d displacement(const LocalVector& u) const noexcept;
  Eigen::Vector3d rate(const LocalVector& u, const LocalVector& v) const noexcept;
  Eigen::Vector3d second(const LocalVector& v, const LocalVector& w) const noexcept;
  /// direction . dd/du at the displacements u; of a rate of u without the translations.
  void row(const Eigen::Vector3d& direction, const LocalVector& u, Row& out) const noexcept;
  void turning_row(const Eigen::Vector3d& direction, const LocalVector& v, Row& out) const noexcept;

  Eigen::Vector3d l_0_vector_;
  double l_0_;
  End ends_[2];
};

}  // namespace stillframe
