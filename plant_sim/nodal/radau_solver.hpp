#pragma once

#include <complex>
#include <optional>
#include <vector>

#include "plant_sim/motion/status.hpp"
#include "plant_sim/nodal/collocation.hpp"
#include "plant_sim/nodal/equations.hpp"
#include "plant_sim/nodal/low_pass.hpp"

namespace stillframe::nodal {

using Status = MotionStatus;

/// The Radau IIA method on the equations in nodal coordinates, index 1, one part at a time in equal
/// steps. With V = v_0 + h A a and X = x_0 + h c v_0 + h^2 A^2 a at the stages, the unknowns are
/// their accelerations and multipliers alone; the eigenvalues mu of A split Newton's matrix into
///   [M + h mu C + h^2 mu^2 K, D^T; D + .., 0].
/// Being a one-step method it goes on through jumps of held inputs in full order and step, and the
/// factors serve until the motion has changed the matrix. Set-up: construction; the rest is hot:
/// noexcept, no allocation.
class RadauSolver {
 public:
  /// equations must outlive this. stages: odd. Errors: std::invalid_argument.
  RadauSolver(Equations& equations, double relative_tolerance, Index stages = 5);

  /// Moves a consistent state on by a duration (s), from t = 0 of the inputs. The error of a step
  /// is kept below its share of the relative tolerance times what an acceleration does in the
  /// duration: the largest of the part, as far as rates follow it, at least the one given (m/s^2,
  /// rad/s^2). The accelerations and multipliers of the result are those of the last stage.
  Status advance(NodalState& state, const Inputs& inputs, double duration, double least) noexcept;
  /// Goes on elsewhere: nothing is taken from the last step.
  void forget() noexcept { previous_h_ = 0; }

  /// From here on carries low-passes of some stresses along. set-up.
  void filter(std::vector<Index> rows, double rate) {
    low_pass_.emplace(std::move(rows), rate, method_);
  }
  /// Those, if there are any; they belong to the state that advance() moves.
  std::optional<LowPass>& low_pass() noexcept { return low_pass_; }

  long evaluations() const noexcept { return evaluations_; }
  long steps() const noexcept { return steps_; }

 private:
  enum class Outcome { accepted, too_large, no_convergence, singular };
  Outcome step(NodalState& state, const Inputs& inputs, double t, double h) noexcept;
  bool renew(const NodalState& state, double h, bool derivatives) noexcept;
  void predict(const NodalState& state, double h) noexcept;
  bool solve_stages(const NodalState& start, const Inputs& inputs, double t, double h) noexcept;
  void stage_residuals(const NodalState& start, const Inputs& inputs, double t, double h,
                       LowPass* seen) noexcept;
  double change_of_rates(const NodalState& start, double h) noexcept;
  double correct(const NodalState& start, double h) noexcept;
  double error(const NodalState& start, double h) noexcept;
  double weigh(double position, double rate, double acceleration, double change) const noexcept;

  Equations& equations_;
  Collocation method_;
  double relative_tolerance_;
  Factors<double> real_;
  std::vector<Factors<std::complex<double>>> pairs_;
  Eigen::MatrixXd unknowns_, residuals_, before_, update_;  ///< size() x s, (x'', lambda)
  Eigen::MatrixXd rates_, moves_;                           ///< n_f x s, h A a and h^2 A^2 a
  Eigen::MatrixXd ahead_;  ///< s x s, from the stages of the last step to those of the next
  double ahead_ratio_ = 0;
  Eigen::VectorXd r_, dx_, dv_, begin_rates_;
  Eigen::VectorXcd z_;
  NodalState stage_;
  std::optional<LowPass> low_pass_;
  double duration_ = 0, acceleration_ = 0;  ///< s, m/s^2: of the present part, the largest in it
  double least_ = 0;                        ///< m/s^2, acceleration that counts in any case
  double change_ = 0;  ///< m/s, how far the rates of the part went from where it began
  double share_ = 1;   ///< of the tolerance, for the present step
  double error_ = 0;
  double factored_h_ = 0, previous_h_ = 0, suggested_h_ = 0;  ///< s, 0: none yet
  double contraction_ = 0;  ///< of Newton's method in the last step that needed two iterations
  bool has_derivatives_ = false, fresh_ = false;
  long evaluations_ = 0, steps_ = 0;
};

}  // namespace stillframe::nodal
