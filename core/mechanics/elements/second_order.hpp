#pragma once

#include "core/mechanics/elements/element.hpp"

namespace stillframe {

/// A beam whose deformations have second-order terms beside those of its chord,
///   e_i = c_i + c^T Q_i c / 2,
/// with c the deformations of the inner element and Q_i constant and symmetric. They make the
/// elongation that of the bent arc, so that shortening and geometric stiffness within one element
/// are right to the second order (J. B. Jonker, J. P. Meijaard, SPACAR, in Multibody Systems
/// Handbook, 1990).
class SecondOrder final : public Element {
 public:
  /// terms: Q_i (n_e x n_e), one for each deformation of the inner element.
  SecondOrder(std::unique_ptr<const Element> inner, std::vector<LocalStiffness> terms);

  void deformations(const LocalVector& u, LocalDeformation& e) const noexcept override;
  void jacobian(const LocalVector& u, JacobianOut d_e_d_u) const noexcept override;
  void second_derivative(const LocalVector& u, const LocalVector& v, const LocalVector& w,
                         LocalDeformation& result) const noexcept override;
  void jacobian_rates(const LocalVector& u, const LocalVector& v, const LocalVector& a,
                      JacobianOut rate, JacobianOut second_rate) const noexcept override;
  void hessian(const LocalVector& u, const LocalDeformation& sigma,
               LocalHessian& result) const noexcept override;

 private:
  /// Row i is (Q_i c)^T: the derivative of the second-order terms to c.
  LocalStiffness rows(const LocalDeformation& c) const noexcept;
  LocalStiffness with_identity(const LocalDeformation& c) const noexcept;

  std::unique_ptr<const Element> inner_;
  std::vector<LocalStiffness> terms_;
};

/// The terms of a planar (3 deformations) and of a spatial beam (6) of length l_0 (m). Phi of each
/// bending pair as section_stiffness: a part of ends that turn alike is sheared by it, and what is
/// sheared alone stays straight.
std::vector<LocalStiffness> planar_second_order_terms(double l_0, double Phi);
std::vector<LocalStiffness> spatial_second_order_terms(double l_0, double Phi_y, double Phi_z);

}  // namespace stillframe
