#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>

#include "plant_sim/motion/status.hpp"

namespace stillframe {

/// The explicit Runge-Kutta pair 5(4) of Dormand and Prince, in ARKODE, for dy/dt = f(t, y), over
/// one held part of a sample at a time: it keeps its order at the jumps of held inputs. Set-up:
/// construction. hot: advance() does not allocate, but for SUNDIALS' own work space at the first
/// call.
class Integrator {
 public:
  /// dy/dt = f(t, y), false if it cannot be evaluated there; t counts from the start of the part,
  /// s. Must not throw: it is called from C.
  using RightHandSide = std::function<bool(double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                                           Eigen::Ref<Eigen::VectorXd> dy_dt)>;

  /// y = (n positions, n velocities, n_filtered filtered positions). relative_tolerance: error of a
  /// step, root of the mean square over all of y, against what the acceleration of advance() does
  /// within the time that it has there. Errors: std::runtime_error if SUNDIALS cannot be set up.
  Integrator(Eigen::Index n, RightHandSide f, double relative_tolerance,
             Eigen::Index n_filtered = 0);
  ~Integrator();
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  using Status = MotionStatus;

  /// Integrates y from 0 to duration (s). acceleration (m/s^2): the largest in the part; within
  /// (s): up to duration, for how long it may go one way.
  Status advance(Eigen::VectorXd& y, double duration, double acceleration, double within) noexcept;

  /// Right-hand sides evaluated since construction.
  long evaluations() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillframe
