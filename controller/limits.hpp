#pragma once

#include <Eigen/Core>
#include <optional>

#include "controller/policy.hpp"

namespace stillframe::controller {

/// The last gate: every force, whichever way it came about, goes through here on its way to the
/// actuators, and nothing comes after it. For every leg by itself, F_0 its last command:
///   |F - F_0| <= T dF_max,   (F^2 - F_0^2) / (2 k) <= T P_max where |F| grows,   |F| <= F_max,
/// in this order, and F = F_0 where F is not finite. k is the stiffness of the actuator, F^2 / (2
/// k) the energy that it holds; what flows back is not limited, so that a force can always be let
/// go. T is one sample however many were missed: the amplifiers meet the step, not its history.
/// Construction is set-up; the rest is hot: noexcept, no allocation.
class Limits {
 public:
  /// force_limit_n: N, > 0, or none; rate and power from the policy; m legs; sample_time: s.
  /// Errors: std::invalid_argument on a value that is not positive.
  Limits(std::optional<double> force_limit_n, const Policy& policy, Eigen::Index m,
         double sample_time);

  /// Limits the force (m, N) that is about to be commanded; pace: m, N, the largest change, beside
  /// the rate limit of the policy; empty: none. Returns whether any force was limited, and whether
  /// one would have been without a pace.
  struct Passed {
    bool limited = false, by_actuator = false;
  };
  Passed pass(Eigen::Ref<Eigen::VectorXd> force,
              const Eigen::Ref<const Eigen::VectorXd>& pace = Eigen::VectorXd()) noexcept;

  /// No force acts: whoever held one has let go of it.
  void let_go() noexcept { last_.setZero(); }
  /// True if a force (m, N) is that cannot pass.
  bool is_beyond(const Eigen::Ref<const Eigen::VectorXd>& applied) const noexcept {
    return (applied.array().abs() > force_).any();
  }

  const Eigen::VectorXd& last() const noexcept { return last_; }

  template <class Archive>
  void visit(Archive& archive) {
    archive(last_);
  }

 private:
  double allowed(double before, double wanted, double rate) const noexcept;

  double force_, rate_, energy_;  ///< N; N and N^2 a sample: infinite where there is no limit
  Eigen::VectorXd last_;          ///< m, N, the last command
};

}  // namespace stillframe::controller
