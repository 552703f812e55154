#pragma once

#include <vector>

#include "core/dynamics.hpp"
#include "core/equilibrium.hpp"
#include "plant_sim/motion/inputs.hpp"

namespace stillframe {

/// The nonlinear equations of motion of a model in minimal coordinates as dy/dt = f(t, y), with the
/// elastic part of the filtered leg stresses,
///   y = (q^d - q_0, q'^d, s_e / k),   s_e' = omega_s (sigma_e - s_e),
/// counted from the equilibrium q_0; k makes stresses as large as positions. Set-up: construction.
/// The rest is hot: noexcept, no allocation.
class MinimalEquations {
 public:
  /// legs: rows of e whose stress is measured; filter_rate: omega_s (1/s), 0 if there is no filter.
  /// model must outlive the equations.
  MinimalEquations(const Model& model, const Equilibrium& rest, std::vector<Index> legs,
                   double filter_rate);

  Index n_d() const noexcept { return model_.n_d; }
  Index n_legs() const noexcept { return static_cast<Index>(legs_.size()); }
  Index n_filtered() const noexcept { return filter_rate_ > 0 ? n_legs() : 0; }
  Index size() const noexcept { return 2 * n_d() + n_filtered(); }
  const Model& model() const noexcept { return model_; }
  const std::vector<Index>& legs() const noexcept { return legs_; }

  /// f(t, y) under the inputs, t in s; false if it cannot be evaluated there. Leaves positions,
  /// rates and stresses there in data().
  bool evaluate(const Inputs& inputs, double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                Eigen::Ref<Eigen::VectorXd> dy_dt) noexcept;

  /// df/dy at an instant where evaluate() was called last, from the linearised equations there
  /// (n x n). Source: deck, sections 5 to 8. Set-up of implicit steps: allocates.
  bool jacobian(Eigen::MatrixXd& J);
  /// The stresses of the legs as outputs of a linear model.
  std::vector<SceneSignal> leg_outputs() const;

  const Data& data() const noexcept { return data_; }
  /// Nodal positions (n_x) near which the next evaluation is.
  void place(const Eigen::VectorXd& x) noexcept { data_.x = x; }
  /// sigma of a leg at the last evaluation, its equilibrium value removed (N), and what is elastic
  /// of it.
  double stress(Index leg) const noexcept;
  double elastic_stress(Index leg) const noexcept;
  /// k (N/m) and omega_s (1/s).
  double stress_scale() const noexcept { return stress_scale_; }
  double filter_rate() const noexcept { return filter_rate_; }
  /// Largest acceleration that rounding leaves in the equilibrium (m/s^2, rad/s^2): no error below
  /// it means anything.
  double rest_acceleration() const noexcept { return rest_acceleration_; }
  /// q''^d at the last evaluation.
  const Eigen::VectorXd& q_d_ddot() const noexcept { return q_d_ddot_; }
  long evaluations() const noexcept { return evaluations_; }

 private:
  const Model& model_;
  std::vector<Index> legs_;
  double filter_rate_;
  double stress_scale_;
  Data data_;
  MotionState state_;
  Eigen::VectorXd q_0_, sigma_0_;       ///< n_d, n_e
  Eigen::VectorXd sigma_a_, q_d_ddot_;  ///< n_e, n_d
  double rest_acceleration_ = 0;
  std::unique_ptr<Lineariser> lineariser_;  ///< made when a Jacobian is first asked for
  long evaluations_ = 0;
};

/// The stiffness of the stiffest of these deformations (N/m, N m/rad), 1 if none resists.
double largest_stiffness(const Model& model, const std::vector<Index>& rows);

}  // namespace stillframe
