#pragma once

#include <vector>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/linearisation/linearisation.hpp"
#include "plant_sim/motion/inputs.hpp"
#include "plant_sim/motion/motion.hpp"

namespace stillframe {

/// The nonlinear equations of motion of a model in minimal coordinates as dy/dt = f(t, y), with the
/// elastic part of the filtered leg stresses,
///   y = (q^d - q_0, q'^d, s_e / k),   s_e' = omega_s (sigma_e - s_e),
/// counted from the operating point q_0; k makes stresses as large as positions. Set-up:
/// construction. The rest is hot: noexcept, no allocation.
class MinimalEquations {
 public:
  /// legs: rows of e whose stress is measured; filter_rate: omega_s (1/s), 0 if there is no filter.
  /// model must outlive the equations.
  MinimalEquations(const Model& model, const NominalMotion& nominal, std::vector<Index> legs,
                   double filter_rate);

  Index n_d() const noexcept { return model_.n_d; }
  Index n_legs() const noexcept { return static_cast<Index>(legs_.size()); }
  Index n_filtered() const noexcept { return filter_rate_ > 0 ? n_legs() : 0; }
  Index size() const noexcept { return 2 * n_d() + n_filtered(); }
  const Model& model() const noexcept { return model_; }
  const std::vector<Index>& legs() const noexcept { return legs_; }

  /// f(t, y) under the inputs, t in s; false if it cannot be evaluated there, or only beyond a dead
  /// point, at which dofs do not say where the frame is. Leaves positions, rates and stresses there
  /// in data().
  bool evaluate(const Inputs& inputs, double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                Eigen::Ref<Eigen::VectorXd> dy_dt) noexcept;
  /// The same of a y that need not be where the motion comes to: the next evaluation starts from
  /// the positions of before. Near a singular one those at y may be on the other side of it.
  bool look(const Inputs& inputs, double t, const Eigen::Ref<const Eigen::VectorXd>& y,
            Eigen::Ref<Eigen::VectorXd> dy_dt) noexcept;

  /// The motion has come to the last y that was evaluated.
  void keep() noexcept;
  /// Back to where it has come to: what an attempt in vain has found since may be anywhere.
  void go_back() noexcept;

  /// y at the operating point (n).
  Eigen::VectorXd start() const;
  /// As NonlinearMotion, of a motion that stands at y.
  bool hand_over(const Drive& drive, const Eigen::VectorXd& y, MotionSnapshot& to) noexcept;
  void take_over(const MotionSnapshot& from) noexcept;
  /// The stresses of the legs as outputs of a linear model.
  std::vector<SceneSignal> leg_outputs() const;

  const Data& data() const noexcept { return data_; }
  /// sigma of a leg at the last evaluation, its value at the operating point removed (N), and what
  /// is elastic of it.
  double stress(Index leg) const noexcept;
  double elastic_stress(Index leg) const noexcept;
  /// k (N/m) and omega_s (1/s).
  double stress_scale() const noexcept { return stress_scale_; }
  double filter_rate() const noexcept { return filter_rate_; }
  /// Largest acceleration that rounding leaves in the operating point (m/s^2, rad/s^2): no error
  /// below it means anything.
  double rest_acceleration() const noexcept { return rest_acceleration_; }
  /// What rounding of the displacements and stresses there makes of each q''^d (n_d), beside what
  /// its forces make: that of a stiff and light element may be much, but is over as soon.
  const Eigen::VectorXd& rounding() const noexcept { return rounding_; }
  /// q''^d at the last evaluation.
  const Eigen::VectorXd& q_d_ddot() const noexcept { return q_d_ddot_; }
  long evaluations() const noexcept { return evaluations_; }

 private:
  Eigen::VectorXd stress_sizes(bool of_displacements) const;
  Eigen::VectorXd accelerations_of_rounding(const Eigen::VectorXd& stresses) const;
  void see_rounding_on_the_way(const NominalMotion& nominal);
  void return_to(const Eigen::VectorXd& x, const Eigen::VectorXd& e) noexcept;
  /// Positions, rates and accelerations of state_, on the branch of where the motion has been;
  /// false if there are none.
  bool solve() noexcept;

  const Model& model_;
  std::vector<Index> legs_;
  double filter_rate_;
  double stress_scale_;
  Data data_;
  Eigen::VectorXd reached_x_, reached_e_;  ///< n_x, n_e, at the last evaluation that could be made
  Eigen::VectorXd before_x_, before_e_;    ///< the same, before a look
  Eigen::VectorXd kept_x_, kept_e_;        ///< the same, where the motion has been
  MotionState state_;
  Eigen::VectorXd q_0_, q_dot_0_, sigma_0_;  ///< n_d, n_d, n_e
  Eigen::VectorXd sigma_a_, q_d_ddot_;       ///< n_e, n_d
  Eigen::VectorXd rounding_;                 ///< n_d
  double rest_acceleration_ = 0;
  int branch_ = 1;  ///< sign of the determinant of J where the dofs say where the frame is
  long evaluations_ = 0;
};

/// The stiffness of the stiffest of these deformations (N/m, N m/rad), 1 if none resists.
double largest_stiffness(const Model& model, const std::vector<Index>& rows);

}  // namespace stillframe
