#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "controller/gains.hpp"
#include "core/linear/discrete_law.hpp"

namespace stillframe::controller {

/// The sampled control law of a set of gains, by Tustin's rule s = (2/T)(z - 1)/(z + 1).
///   implicit_feedthrough: C'(s) = -(I + P)^-1 P = -(X s + w_l I + K_I)^-1 (K_P s + K_I), X = I +
///   K_P,
///     acting on sigma less the applied force; naive_pi: -(K_P + K_I/(s + w_l)) acting on sigma;
///   with lead_samples = a > 0, e[k] is first replaced by (1 + a) e[k] - a e[k-1], which makes up
///   for a force that acts a samples after its measurement (the delay, and half a sample of hold);
///   either is followed by w_r/(s + w_r) if there is a roll-off.
/// Source: THEORY section 4, fact 3. Set-up. Errors: Refusal if I + K_P is singular,
/// std::invalid_argument on gains that are not square or not of one size.
DiscreteLaw law_from_gains(const Gains& gains);

/// The law as it runs, one step a sample:
///   e[k] = sigma[k] - (subtract_applied ? applied[k] : 0),
///   u[k] = C x[k] + D e[k],   x[k+1] = A x[k] + B e[k].
/// Source: core/linear/discrete_law.hpp. Construction is set-up; step and reset are
/// hot: noexcept, no allocation.
class Law {
 public:
  /// Errors: std::invalid_argument on shapes that do not match.
  explicit Law(DiscreteLaw matrices);

  Eigen::Index n_legs() const noexcept { return matrices_.D.rows(); }

  /// One sample: sigma, applied and force are m forces in N; writes force and moves the state.
  void step(const Eigen::Ref<const Eigen::VectorXd>& sigma,
            const Eigen::Ref<const Eigen::VectorXd>& applied,
            Eigen::Ref<Eigen::VectorXd> force) noexcept;

  /// The same where n_samples samples have passed since the last step (1: none was missed): the law
  /// runs through all of them, with e interpolated linearly between its last value and the present
  /// one. Without that, a missed sample would stop the law's clock, and a lead would take the
  /// change over n samples for that over one. At most 100 samples are made up for.
  void step_over(std::int64_t n_samples, const Eigen::Ref<const Eigen::VectorXd>& sigma,
                 const Eigen::Ref<const Eigen::VectorXd>& applied,
                 Eigen::Ref<Eigen::VectorXd> force) noexcept;

  /// Back to rest, x = 0 and e = 0.
  void reset() noexcept {
    x_.setZero();
    e_last_.setZero();
  }

  /// n states of the law, N.
  const Eigen::VectorXd& state() const noexcept { return x_; }

 private:
  void advance() noexcept;

  DiscreteLaw matrices_;
  Eigen::VectorXd x_, x_next_, e_, e_now_, e_last_;
};

}  // namespace stillframe::controller
