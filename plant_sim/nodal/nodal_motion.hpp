#pragma once

#include <vector>

#include "core/mechanics/kinematics.hpp"
#include "plant_sim/nodal/consistent.hpp"
#include "plant_sim/nodal/radau_solver.hpp"

namespace stillframe::nodal {

/// The motion of a model in nodal coordinates, part by part, with the inputs smooth within each
/// part. Set-up: construction. hot: advance() is noexcept, and allocates at the first call only.
class NodalMotion {
 public:
  /// Starts at x and x' of start, its hinges turned as in e. relative_tolerance: of a step, against
  /// what the largest acceleration does in its part. model must outlive this.
  NodalMotion(const Model& model, const Data& start, double relative_tolerance, Index stages = 5);

  /// Goes on from other positions and rates (n_x), nearly consistent ones, with the filters where
  /// they stand there and elastic hinges turned so far (n_e, rad).
  void take_over(const Eigen::VectorXd& x, const Eigen::VectorXd& x_dot,
                 const Eigen::VectorXd& filtered, const Eigen::VectorXd& turns) noexcept;
  /// How far hinges have turned at the start of the last part, on their first deformations (n_e).
  const Eigen::VectorXd& turns() const noexcept { return equations_.turns(); }

  /// Moves on by a duration (s). The held deformations and their rates are met to rounding at the
  /// end. After a failure the state is that of the start of the part.
  Status advance(const Inputs& inputs, double duration) noexcept;

  /// From the present state on, low-passes s' = rate (sigma - sigma_a - s) of some stresses (rows
  /// of e; rate: 1/s), which start where they are at rest. set-up.
  void filter(std::vector<Index> rows, double rate);
  /// Those (one each, N).
  const Eigen::VectorXd& filtered() const noexcept { return filtered_; }

  const Eigen::VectorXd& x() const noexcept { return state_.x; }
  const Eigen::VectorXd& x_dot() const noexcept { return state_.x_dot; }
  /// Of the end of the last part, before the inputs jump.
  const Eigen::VectorXd& x_ddot() const noexcept { return state_.x_ddot; }
  /// All stresses there (n_e): reactions of the held deformations, the driving stresses included.
  const Eigen::VectorXd& sigma() const noexcept { return equations_.sigma(); }
  /// Their driving part (n_e).
  const Eigen::VectorXd& sigma_a() const noexcept { return equations_.sigma_a(); }
  /// Residuals evaluated and steps made since construction.
  long evaluations() const noexcept { return solver_.evaluations(); }
  long steps() const noexcept { return solver_.steps(); }

 private:
  Status attempt(const Inputs& inputs, double duration) noexcept;
  Status begin(const Inputs& inputs) noexcept;
  Status finish(const Inputs& inputs, double duration) noexcept;

  double relative_tolerance_;
  Equations equations_;
  Consistency consistency_;
  RadauSolver solver_;
  NodalState state_, before_;
  Eigen::VectorXd filtered_;
  bool consistent_ = false, filters_started_ = false;
  bool rounding_known_ = false;
  double least_scale_ = 0;  ///< m/s^2, of rounding, over the tolerance
};

}  // namespace stillframe::nodal
