#pragma once

#include "plant_sim/integrator.hpp"
#include "plant_sim/motion/frame_points.hpp"
#include "plant_sim/motion/minimal_equations.hpp"
#include "plant_sim/motion/motion.hpp"

namespace stillframe {

/// The nonlinear plant in minimal coordinates, integrated by explicit steps (Integrator).
class OdeMotion final : public NonlinearMotion {
 public:
  /// relative_tolerance: of a step (see Integrator); fastest: rad/s, of the modes about the
  /// operating point.
  OdeMotion(MinimalEquations equations, FramePoints points, double relative_tolerance,
            double fastest);

  Status advance(const Drive& drive, double duration) noexcept override;
  void velocities(Eigen::VectorXd& v) const noexcept override;
  void elastic_stresses(Eigen::VectorXd& sigma) const noexcept override;
  void filtered_stresses(Eigen::VectorXd& sigma) const noexcept override;
  long evaluations() const noexcept override { return integrator_.evaluations() + n_looks_; }
  Eigen::VectorXd displacements() const override;
  bool hand_over(const Drive& drive, MotionSnapshot& to) noexcept override;
  void take_over(const MotionSnapshot& from) noexcept override;
  /// y as MinimalEquations has it.
  const Eigen::VectorXd& state() const noexcept { return y_; }

 private:
  MinimalEquations equations_;
  FramePoints points_;
  const Drive* drive_ = nullptr;  ///< of the present part
  double relative_tolerance_, least_scale_;
  double longest_;     ///< s, for which the fastest mode may accelerate one way
  double last_t_ = 0;  ///< s, of the last evaluation in the part
  Integrator integrator_;
  Eigen::VectorXd y_, rate_;
  long n_looks_ = 0;  ///< evaluations before and after parts
};

}  // namespace stillframe
