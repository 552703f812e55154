#pragma once

#include <Eigen/Core>
#include <optional>

#include "controller/policy.hpp"

namespace stillframe::controller {

/// What the actuators and their amplifiers allow, for every leg by itself: the rate of the force,
/// the power of the amplifier and the force, in this order.
///   |F - F_0| <= dt dF_max,   (F^2 - F_0^2) / (2 k) <= dt P_max where |F| grows,   |F| <= F_max.
/// k is the stiffness of the actuator, F^2 / (2 k) the energy that it holds; what flows back is not
/// limited, so that a force can always be let go. Construction is set-up; the rest is hot:
/// noexcept, no allocation.
class Limits {
 public:
  /// force_limit_n: N, > 0, or none; rate and power from the policy; sample_time: s.
  /// Errors: std::invalid_argument on a value that is not positive.
  Limits(std::optional<double> force_limit_n, const Policy& policy, double sample_time);

  /// Limits a force (N) against `last`, the one n_samples before. Answers whether any was limited.
  bool apply(const Eigen::Ref<const Eigen::VectorXd>& last, std::int64_t n_samples,
             Eigen::Ref<Eigen::VectorXd> force) const noexcept;

 private:
  double force_, rate_, energy_;  ///< N; N and N^2 a sample: infinite where there is no limit
};

}  // namespace stillframe::controller
