#pragma once

#include <memory>
#include <vector>

#include "plant_sim/motion/linear_step.hpp"
#include "plant_sim/motion/motion.hpp"

namespace stillframe {

/// The nonlinear plant as what its linear equations answer exactly and a small rest,
///   y(t) = y_lin(t) + integral of exp((t - s) A) g(s, y(s)) ds,   g = f - (A y + B u),
/// with g collocated at the three Radau points of a part and found by fixed-point sweeps. Stiffness
/// costs nothing where it is linear, and the nearer the motion is to linear the fewer evaluations
/// are needed: three a part in small motion, where one sweep changes less than the tolerance. A
/// part in which the sweeps converge slowly or the collocation is too coarse is halved. Source:
/// Hochbruck and Ostermann, Acta Numerica 19 (2010) 209-286 (exponential collocation).
class ExponentialMotion final : public NonlinearMotion {
 public:
  /// relative_tolerance: of what a part, halved or not, may err by against what the largest
  /// acceleration does in the whole part. durations: of the parts that there will be, s. Others,
  /// and halves of them, are made when they come first, and then allocate.
  ExponentialMotion(MinimalEquations equations, LinearEquations linear, FramePoints points,
                    double relative_tolerance, const Drive& drive,
                    const std::vector<double>& durations);
  ~ExponentialMotion() override;

  Status advance(const Drive& drive, double duration) noexcept override;
  void velocities(Eigen::VectorXd& v) const noexcept override;
  void elastic_stresses(Eigen::VectorXd& sigma) const noexcept override;
  void filtered_stresses(Eigen::VectorXd& sigma) const noexcept override;
  long evaluations() const noexcept override { return equations_.evaluations(); }
  Eigen::VectorXd displacements() const override;
  bool hand_over(const Drive& drive, MotionSnapshot& to) noexcept override;
  void take_over(const MotionSnapshot& from) noexcept override;
  /// y as MinimalEquations has it.
  const Eigen::VectorXd& state() const noexcept { return y_; }

 private:
  static constexpr int n_nodes = 3;
  struct Part;  ///< the matrices of one duration
  enum class Outcome { ok, halve, cannot_evaluate };
  /// What errors are weighed by: the largest acceleration (m/s^2), and how far the rates went from
  /// where the part began (m/s).
  struct Scale {
    double acceleration = 0, change = 0;
  };

  const Part& part(const Drive& drive, double duration);
  Outcome attempt(const Drive& drive, double from, const Part& part) noexcept;
  bool evaluate_rests(const Drive& drive, double from, const Part& part) noexcept;
  void start_sweeps(const Drive& drive, double from, const Part& part) noexcept;
  double least_acceleration() const noexcept;
  /// The largest of the three kinds of entries of dy over what the tolerance allows there.
  double size_of(const Eigen::VectorXd& dy) const noexcept;
  double rate_of_first(double size) noexcept;
  void extrapolate(const Part& part) noexcept;
  /// What rounding leaves of a part, in the same measure.
  double rounding_size(const Part& part) noexcept;
  void change_at(const Part& part, int node) noexcept;
  /// What the collocation leaves out, in the same measure.
  double collocation_error(const Part& part) noexcept;

  MinimalEquations equations_;
  LinearEquations linear_;
  FramePoints points_;
  double relative_tolerance_;
  std::vector<std::unique_ptr<Part>> parts_;
  /// n_g x n, n_g x n_r, n_g x n_r: entries of A, B_p and B_v without their signs.
  Eigen::MatrixXd A_sizes_, B_p_sizes_, B_v_sizes_;
  LinearStep::Start start_;
  Eigen::VectorXd y_, begin_;  ///< at present, and where the present part began
  /// y at the end of a part, and as it was when the equations were evaluated there; between
  /// advances end_ is the difference of the two.
  Eigen::VectorXd end_, seen_end_;
  Eigen::VectorXd x_dot_;  ///< n_x, at y_
  Eigen::VectorXd change_, rate_, linear_rate_, q_r_, q_r_dot_;
  Eigen::VectorXd legs_a_;     ///< n_legs, driving stresses that the linear part counts
  Eigen::MatrixXd nodes_;      ///< n x 3, y at the nodes
  Eigen::MatrixXd g_, g_new_;  ///< n_g x 3, g of the last sweep and of the present one
  /// Of the part that is being advanced: what sweeps that settled saw, and with the present one.
  Scale known_, seen_;
  double whole_ = 0;          ///< s, duration of the part that is being advanced
  double last_duration_ = 0;  ///< s, of the part whose g is there; 0: there is none
  double rate_ago_ = 1;       ///< of the convergence of the sweeps, as last seen, aged since
  double size_ago_ = 0;       ///< of the first sweep when it was seen
  bool easy_ = false;         ///< the last part would have met the tolerance at twice its length
  bool settled_ = false;      ///< the sweeps of the last attempt came to an end
  int halvings_ = 0;
};

}  // namespace stillframe
