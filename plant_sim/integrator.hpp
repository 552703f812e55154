#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>

namespace stillframe {

/// SUNDIALS ARKODE's explicit Runge-Kutta pair of Dormand and Prince, 5(4), over one held sample at
/// a time. A one-step method loses neither order nor step size at the jumps of held inputs. Set-up:
/// construction. hot: advance() does not allocate, but for SUNDIALS' own work space at the first
/// call.
class Integrator {
 public:
  /// dy/dt = f(t, y), false if it cannot be evaluated there; t counts from the start of the sample,
  /// s. Must not throw: it is called from C.
  using RightHandSide = std::function<bool(double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                                           Eigen::Ref<Eigen::VectorXd> dy_dt)>;

  /// y = (n positions, n velocities, n_filtered filtered positions). relative_tolerance: local
  /// error of each of the three against its largest entry. Errors: std::runtime_error if SUNDIALS
  /// cannot be set up.
  Integrator(Eigen::Index n, RightHandSide f, double relative_tolerance,
             Eigen::Index n_filtered = 0);
  ~Integrator();
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  enum class Status { ok, right_hand_side_failed, too_many_steps, failed };

  /// Integrates y from 0 to duration (s). acceleration_scale (m/s^2) sets what counts as a small
  /// error while y itself is small: the motion that such an acceleration makes within the sample.
  Status advance(Eigen::VectorXd& y, double duration, double acceleration_scale) noexcept;

  /// Right-hand sides evaluated since construction.
  long evaluations() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillframe
