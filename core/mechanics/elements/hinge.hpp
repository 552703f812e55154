#pragma once

#include <complex>

#include "core/mechanics/elements/element.hpp"

namespace stillframe {

/// Spatial hinge between two nodes at one position: three relative rotations, rad,
///   e_1 = 2 arg(mu_0 + i mu . n_x)   about the axis n_x, mu = conj(lambda_p) lambda_q
///   e_2 = -(R_p n_z) . (R_q n_x)     about n_y
///   e_3 =  (R_p n_y) . (R_q n_x)     about n_z
/// e_1 is exact for any angle while e_2 = e_3 = 0; e_2 and e_3 are sines of the tilt of the axis.
/// Local coordinates: rotation p (4), rotation q (4).
class Hinge final : public Element {
 public:
  /// axis: n_x in the scene as written. Errors: std::invalid_argument if it is zero.
  Hinge(Eigen::Index node_p, Eigen::Index node_q, const Eigen::Vector3d& axis);

  void deformations(const LocalVector& u, LocalDeformation& e) const noexcept override;
  void jacobian(const LocalVector& u, JacobianOut d_e_d_u) const noexcept override;
  void second_derivative(const LocalVector& u, const LocalVector& v, const LocalVector& w,
                         LocalDeformation& result) const noexcept override;
  void jacobian_rates(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                      JacobianOut rate, JacobianOut second_rate) const noexcept override;
  void hessian(const LocalVector& u, const LocalDeformation& sigma,
               LocalHessian& result) const noexcept override;
  double period() const noexcept override;

 private:
  using Vector4c = Eigen::Matrix<std::complex<double>, 4, 1>;
  Eigen::Vector3d n_x_, tilt_[2];                ///< tilt_: -n_z and n_y
  Eigen::Matrix<std::complex<double>, 4, 4> Z_;  ///< mu_0 + i mu . n_x = lambda_p^T Z lambda_q
};

}  // namespace stillframe
