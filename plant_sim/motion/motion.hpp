#pragma once

#include <Eigen/Core>
#include <string>

#include "plant_sim/motion/drive.hpp"
#include "plant_sim/motion/status.hpp"

namespace stillframe {

/// A plant in motion by some formulation and some method. Set-up: construction. The rest is hot:
/// noexcept, no allocation but for the work space that SUNDIALS makes at the first call.
class Motion {
 public:
  virtual ~Motion() = default;

  using Status = MotionStatus;

  /// Goes on for a duration (s) under the inputs, which stand at the start of it.
  virtual Status advance(const Drive& drive, double duration) noexcept = 0;

  /// At present: velocities of the frame's points (m/s), elastic stresses of the legs with their
  /// equilibrium values removed (N), and what a low-pass leaves of them (N; empty without one).
  virtual void velocities(Eigen::VectorXd& v) const noexcept = 0;
  virtual void elastic_stresses(Eigen::VectorXd& sigma) const noexcept = 0;
  virtual void filtered_stresses(Eigen::VectorXd& sigma) const noexcept = 0;

  /// Evaluations of the nonlinear equations since construction.
  virtual long evaluations() const noexcept = 0;
  /// How far the dofs are from the operating point (n_d), also where the motion could not go on.
  virtual Eigen::VectorXd displacements() const = 0;
};

/// Where a nonlinear motion stands, whatever its formulation.
struct MotionSnapshot {
  Eigen::VectorXd y;         ///< as MinimalEquations has it
  Eigen::VectorXd x, x_dot;  ///< n_x
  Eigen::VectorXd e;         ///< n_e, with the turns of hinges
};

/// A nonlinear motion that another method can go on with.
class NonlinearMotion : public Motion {
 public:
  /// Writes where the motion stands, at the start of a part of the drive; false if the equations
  /// cannot be evaluated there.
  virtual bool hand_over(const Drive& drive, MotionSnapshot& to) noexcept = 0;
  /// Goes on from there.
  virtual void take_over(const MotionSnapshot& from) noexcept = 0;
};

}  // namespace stillframe
