#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>

namespace stillframe {

/// Methods of SUNDIALS for dy/dt = f(t, y). The first four keep order and step size at the jumps of
/// held inputs; the multistep methods begin again at order one after each.
enum class Scheme {
  dormand_prince,        ///< ARKODE, explicit Runge-Kutta 5(4)
  fehlberg,              ///< ARKODE, explicit Runge-Kutta 8(7)
  runge_kutta,           ///< ARKODE, explicit Runge-Kutta of order 4 in equal steps
  implicit_runge_kutta,  ///< ARKODE, ESDIRK 5(4), L-stable, with the Jacobian of f
  adams,                 ///< CVODE, order 1 to 12
  bdf,                   ///< CVODE, order 1 to 5, with the Jacobian of f
};

/// An integrator over one held part of a sample at a time. Set-up: construction. hot: advance()
/// does not allocate, but for SUNDIALS' own work space at the first call and for Jacobians.
class Integrator {
 public:
  /// dy/dt = f(t, y), false if it cannot be evaluated there; t counts from the start of the part,
  /// s. Must not throw: it is called from C.
  using RightHandSide = std::function<bool(double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                                           Eigen::Ref<Eigen::VectorXd> dy_dt)>;
  /// df/dy (n x n) at the t and y given, false if there is none.
  using Jacobian =
      std::function<bool(double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::MatrixXd& J)>;

  struct Settings {
    Scheme scheme = Scheme::dormand_prince;
    /// Local error of positions, velocities and filtered positions, each against its largest entry.
    double relative_tolerance = 1e-5;
    int steps_per_part = 1;  ///< of runge_kutta, which has no error control
    Jacobian jacobian;       ///< of the implicit methods
  };

  /// y = (n positions, n velocities, n_filtered filtered positions). Errors: std::runtime_error if
  /// SUNDIALS cannot be set up; std::invalid_argument for an implicit scheme without a Jacobian.
  Integrator(Eigen::Index n, RightHandSide f, Settings settings, Eigen::Index n_filtered = 0);
  Integrator(Eigen::Index n, RightHandSide f, double relative_tolerance,
             Eigen::Index n_filtered = 0);
  ~Integrator();
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  enum class Status { ok, right_hand_side_failed, too_many_steps, failed };

  /// Integrates y from 0 to duration (s). acceleration_scale (m/s^2) sets what counts as a small
  /// error while y itself is small: the motion that such an acceleration makes within the part.
  Status advance(Eigen::VectorXd& y, double duration, double acceleration_scale) noexcept;

  /// Right-hand sides evaluated since construction.
  long evaluations() const noexcept;

  class Backend;  ///< one integrator of SUNDIALS

 private:
  std::unique_ptr<Backend> backend_;
};

}  // namespace stillframe
