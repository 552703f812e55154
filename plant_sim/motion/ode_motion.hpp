#pragma once

#include "plant_sim/integrator.hpp"
#include "plant_sim/motion/frame_points.hpp"
#include "plant_sim/motion/minimal_equations.hpp"
#include "plant_sim/motion/motion.hpp"

namespace stillframe {

/// The nonlinear plant in minimal coordinates, integrated by a method of SUNDIALS.
class OdeMotion final : public Motion {
 public:
  OdeMotion(MinimalEquations equations, FramePoints points, Integrator::Settings settings);

  /// Goes on from a state y at nodal positions x. hot.
  void start_from(const Eigen::VectorXd& y, const Eigen::VectorXd& x) noexcept {
    y_ = y;
    equations_.place(x);
  }

  Status advance(const Drive& drive, double duration) noexcept override;
  void velocities(Eigen::VectorXd& v) const noexcept override;
  void elastic_stresses(Eigen::VectorXd& sigma) const noexcept override;
  void filtered_stresses(Eigen::VectorXd& sigma) const noexcept override;
  long evaluations() const noexcept override { return integrator_.evaluations(); }
  std::string where() const override;
  /// y as MinimalEquations has it.
  const Eigen::VectorXd& state() const noexcept { return y_; }

 private:
  Integrator::Settings with_jacobian(Integrator::Settings settings);

  MinimalEquations equations_;
  FramePoints points_;
  const Drive* drive_ = nullptr;  ///< of the present part
  double relative_tolerance_, least_scale_;
  Integrator integrator_;
  Eigen::VectorXd y_, rate_;
};

}  // namespace stillframe
