#include "controller/limits.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/numerics/infinity.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::Ref;
using Eigen::VectorXd;

namespace {

double checked(const char* what, std::optional<double> value) {
  if (!value) return infinity;
  if (*value > 0) return *value;
  throw std::invalid_argument(std::string("Limits: ") + what + " must be positive, got " +
                              std::to_string(*value));
}

}  // namespace

Limits::Limits(std::optional<double> force_limit_n, const Policy& policy, Index m,
               double sample_time)
    : force_(checked("the force limit", force_limit_n)),
      rate_(checked("the rate limit", policy.rate_limit_n_per_s) *
            checked("the sample time", sample_time)),
      energy_(2 * checked("the power limit", policy.power_limit_w) *
              checked("the actuator's stiffness",
                      policy.power_limit_w ? policy.actuator_stiffness_n_per_m : 1.0) *
              sample_time),
      last_(VectorXd::Zero(m)) {}

double Limits::allowed(double before, double wanted, double rate) const noexcept {
  double force = before;
  if (std::isfinite(wanted)) {
    force = std::clamp(wanted, before - rate, before + rate);
    // Through zero the energy starts from nothing.
    const double held = before * force > 0 ? before * before : 0;
    const double largest = std::max(std::sqrt(held + energy_), held > 0 ? std::abs(before) : 0.0);
    force = std::clamp(force, -largest, largest);
  }
  return std::clamp(force, -force_, force_);
}

Limits::Passed Limits::pass(Ref<VectorXd> force, const Ref<const VectorXd>& pace) noexcept {
  Passed passed;
  for (Index i = 0; i < force.size(); ++i) {
    const double before = last_(i), wanted = force(i);
    // Not a number is no pace to go at.
    const double most = pace.size() == 0 ? rate_ : pace(i) >= 0 ? pace(i) : 0;
    force(i) = last_(i) = allowed(before, wanted, std::min(rate_, most));
    passed.limited |= force(i) != wanted;
    passed.by_actuator |= allowed(before, wanted, rate_) != wanted;
  }
  return passed;
}

}  // namespace stillframe::controller
