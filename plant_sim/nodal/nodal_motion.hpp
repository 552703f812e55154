#pragma once

#include <memory>
#include <vector>

#include "core/kinematics.hpp"
#include "plant_sim/nodal/consistent.hpp"
#include "plant_sim/nodal/ida_solver.hpp"
#include "plant_sim/nodal/radau_solver.hpp"

namespace stillframe::nodal {

/// How the equations are integrated: one-step collocation, or IDA's formulas with variable order.
enum class Method { radau, ida };

/// The motion of a model in nodal coordinates, part by part, with the inputs smooth within each
/// part. Set-up: construction. hot: advance() is noexcept, and allocates at the first call only.
class NodalMotion {
 public:
  /// Starts at x and x' of start. relative_tolerance: local error of positions and of rates against
  /// the largest change since the start of the part, or what the acceleration does in it. model
  /// must outlive this. Errors: std::runtime_error if SUNDIALS cannot be set up.
  NodalMotion(const Model& model, const Data& start, double relative_tolerance,
              Method method = Method::radau, Index stages = 5);

  /// Moves on by a duration (s). The held deformations and their rates are met to rounding at the
  /// end. After a failure the state is that of the start of the part.
  Status advance(const Inputs& inputs, double duration) noexcept;

  /// From the present state on, low-passes s' = rate (sigma - sigma_a - s) of some stresses (rows
  /// of e; rate: 1/s), which start where they are at rest. set-up. Errors: std::invalid_argument
  /// with IDA, which does not carry them.
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
  long evaluations() const noexcept;
  long steps() const noexcept;

 private:
  Status begin(const Inputs& inputs) noexcept;
  Status finish(const Inputs& inputs, double duration) noexcept;

  double relative_tolerance_;
  Equations equations_;
  Consistency consistency_;
  std::unique_ptr<IdaSolver> ida_;
  std::unique_ptr<RadauSolver> radau_;
  NodalState state_, before_;
  Eigen::VectorXd filtered_;
  bool consistent_ = false, filters_started_ = false;
  double least_scale_ = 0;  ///< m/s^2, of rounding, over the tolerance
};

}  // namespace stillframe::nodal
