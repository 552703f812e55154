#pragma once

#include <Eigen/Core>

#include "core/linear/instruments.hpp"

namespace stillframe {

/// The actuators of all legs with their amplifiers. A command u, limited to c, moves the force f
/// that they know of, and g f acts:
///   c = max(-f_max, min(f_max, u)),   f' = omega_a (c - f), without lag f = c,   sigma_a = g f.
/// While a command stands, f(t) = c + (f(0) - c) exp(-omega_a t), in closed form.
/// Set-up: construction. The rest is hot: noexcept, no allocation.
class Actuators {
 public:
  /// At rest. force_limit: f_max, N, may be infinite.
  Actuators(Eigen::Index n_legs, double force_limit, const Instruments& instruments);

  /// From now on the command u (n_legs, N) stands.
  void command(const Eigen::Ref<const Eigen::VectorXd>& u) noexcept;
  /// sigma_a (N) of one leg a time t (s) after the command, and where it tends to.
  double acting(Eigen::Index leg, double t) const noexcept;
  double settled(Eigen::Index leg) const noexcept { return gain_ * command_(leg); }
  /// The forces go on for a duration (s) under the command.
  void finish(double duration) noexcept;
  /// A sample ends here: what is read out now is what report() says once it has its age.
  void sample() noexcept;

  /// The force reported as applied (n_legs, N): f or c by the instruments, so many samples old.
  const Eigen::VectorXd& report() const noexcept { return report_; }
  bool lags() const noexcept { return rate_ > 0; }

  /// g c and g (f - c) at present (N): the force that acts from here on is
  /// settled + transient exp(-rate t), rate in 1/s.
  double transient(Eigen::Index leg) const noexcept {
    return gain_ * (force_(leg) - command_(leg));
  }
  double rate() const noexcept { return rate_; }

 private:
  double limit_, gain_, rate_;  ///< f_max, g, omega_a (0: no lag)
  Instruments::Report kind_;
  Eigen::VectorXd command_, force_, report_;  ///< c, f, what is reported
  Eigen::MatrixXd aged_;                      ///< n_legs x (age + 1), a ring of what was read out
  Eigen::Index newest_ = 0;
};

}  // namespace stillframe
