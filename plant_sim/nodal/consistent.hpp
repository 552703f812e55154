#pragma once

#include "plant_sim/nodal/equations.hpp"

namespace stillframe::nodal {

/// Makes states satisfy the equations, with the inputs that these have taken. The factors of
/// [M, D_con^T; D_con, 0] that it iterates with are kept from state to state and renewed where they
/// converge slowly. Set-up: construction; the rest is hot: noexcept, no allocation, and answers
/// false where it does not converge.
class Consistency {
 public:
  /// equations must outlive this.
  explicit Consistency(Equations& equations);

  /// Moves the free coordinates by the least motion, measured by the mass, that brings the held
  /// deformations where they belong: M dx + D_con^T mu = 0, D_con dx = e_r - e, repeated.
  bool positions(NodalState& state) noexcept;
  /// The same for the rates, and then x'' and lambda by iterative refinement from what they are.
  bool rates(NodalState& state) noexcept;
  bool accelerations(NodalState& state) noexcept;
  /// Largest acceleration (m/s^2, rad/s^2) that rounding of the forces of a state makes, after
  /// accelerations(); from here on they are not asked to be better. set-up.
  double measure_rounding(const NodalState& state);

 private:
  bool renew(const NodalState& state) noexcept;
  template <class Errors, class Subtract>
  bool iterate(const NodalState& state, const Errors& errors, const Subtract& subtract,
               const Eigen::VectorXd& size_of, double rounding, bool linear) noexcept;

  Equations& equations_;
  Factors<double> factors_;
  Eigen::VectorXd r_;
  double rounding_ = 0;
  bool factorised_ = false;
};

}  // namespace stillframe::nodal
