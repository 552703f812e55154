#pragma once

#include <Eigen/Core>

#include "core/numerics/infinity.hpp"
#include "core/systems/bouc_wen.hpp"
#include "core/systems/instruments.hpp"

namespace stillframe {

/// The actuators of all legs with their amplifiers. A command u, limited to c, moves the force f
/// that they know of as fast as lag and rate limit let it, and F acts:
///   c = max(-f_max, min(f_max, u)),   f' = max(-R, min(R, omega_a (c - f))),   F = sigma_a = g f,
/// without lag f goes to c at the rate R, without either it jumps there. With hysteresis
/// F = g (kappa f - h) as BoucWen. While a command stands, f goes one way, so all has a closed
/// form: at the rate R until t_1, f(t) = c + (f(t_1) - c) exp(-omega_a (t - t_1)) from there, h
/// along f. Set-up: construction. The rest is hot: noexcept, no allocation.
class Actuators {
 public:
  /// At rest. force_limit: f_max, N, may be infinite.
  Actuators(Eigen::Index n_legs, double force_limit, const Instruments& instruments);

  /// From now on the command u (n_legs, N) stands.
  void command(const Eigen::Ref<const Eigen::VectorXd>& u) noexcept;
  /// sigma_a (N) of one leg a time t (s) after the command, and where it tends to.
  double acting(Eigen::Index leg, double t) const noexcept;
  double settled(Eigen::Index leg) const noexcept {
    return hysteresis_ ? gain_ * (loop_.kappa * command_(leg) - loop_.moved(h_(leg), way(leg)))
                       : gain_ * command_(leg);
  }
  /// The forces go on for a duration (s) under the command.
  void finish(double duration) noexcept;
  /// A sample ends here: what is read out now is what report() says once it has its age.
  void sample() noexcept;

  /// The force reported as applied (n_legs, N): f or c by the instruments, so many samples old.
  const Eigen::VectorXd& report() const noexcept { return report_; }
  /// True if forces move while a command stands.
  bool lags() const noexcept { return rate_ > 0 || slews(); }
  /// True if they then do so by one exponential: settled + transient exp(-rate t).
  bool exponential() const noexcept { return rate_ > 0 && !slews() && !hysteresis_; }

  /// g c and g (f - c) at present (N), if nothing but a lag is there; omega_a, 1/s.
  double transient(Eigen::Index leg) const noexcept {
    return gain_ * (force_(leg) - command_(leg));
  }
  double rate() const noexcept { return rate_; }

  /// How long (s, up to a duration) sigma_a stays smooth, until some leg has ended its slewing: an
  /// integrator stops there and goes on under the same command. A billionth of the duration is not
  /// worth a part.
  double smooth_for(double duration) const noexcept;
  /// When the slewing of one leg ends (0 if there is none), and when its h crosses zero where that
  /// bends it (infinity if not), s after the command: in between sigma_a is analytic in t.
  double slewing_ends(Eigen::Index leg) const noexcept;
  double loop_crosses(Eigen::Index leg) const noexcept;
  /// Bound on the rate (1/s) at which sigma_a of a leg changes in proportion to itself.
  double fastest_rate(Eigen::Index leg) const noexcept;

 private:
  bool slews() const noexcept { return rate_limit_ < infinity; }
  /// c - f.
  double way(Eigen::Index leg) const noexcept { return command_(leg) - force_(leg); }
  /// By how much f of a leg has moved a time t (s) after the command.
  double moved(Eigen::Index leg, double t) const noexcept;

  double limit_, gain_, rate_;  ///< f_max, g, omega_a (0: no lag)
  double rate_limit_;           ///< R, N/s
  bool hysteresis_;
  BoucWen loop_;
  Instruments::Report kind_;
  Eigen::VectorXd command_, force_, h_, report_;  ///< c, f, h, what is reported
  Eigen::MatrixXd aged_;  ///< n_legs x (age + 1), a ring of what was read out
  Eigen::Index newest_ = 0;
};

}  // namespace stillframe
