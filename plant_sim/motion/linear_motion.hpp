#pragma once

#include <vector>

#include "plant_sim/motion/linear_step.hpp"
#include "plant_sim/motion/motion.hpp"

namespace stillframe {

/// Small motion: the linearised plant, stepped exactly by exponentials of its state matrix.
class LinearMotion final : public Motion {
 public:
  /// durations: of the parts that there will be, s; others are made when they come, and allocate.
  LinearMotion(LinearEquations equations, double stress_scale, Index n_filtered, const Drive& drive,
               const std::vector<double>& durations);

  Status advance(const Drive& drive, double duration) noexcept override;
  void velocities(Eigen::VectorXd& v) const noexcept override;
  void elastic_stresses(Eigen::VectorXd& sigma) const noexcept override;
  void filtered_stresses(Eigen::VectorXd& sigma) const noexcept override;
  long evaluations() const noexcept override { return 0; }
  Eigen::VectorXd displacements() const override;

 private:
  const LinearStep& step(const Drive& drive, double duration);

  LinearEquations equations_;
  double stress_scale_;
  Index n_filtered_;
  bool strains_;
  std::vector<LinearStep> steps_;
  LinearStep::Start start_, end_;
  Eigen::VectorXd y_, next_;
};

}  // namespace stillframe
