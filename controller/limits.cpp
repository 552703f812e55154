#include "controller/limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace stillframe::controller {

using Eigen::Index;
using Eigen::Ref;
using Eigen::VectorXd;

namespace {

double checked(const char* what, std::optional<double> value) {
  if (!value) return std::numeric_limits<double>::infinity();
  if (*value > 0) return *value;
  throw std::invalid_argument(std::string("Limits: ") + what + " must be positive, got " +
                              std::to_string(*value));
}

}  // namespace

Limits::Limits(std::optional<double> force_limit_n, const Policy& policy, double sample_time)
    : force_(checked("the force limit", force_limit_n)),
      rate_(checked("the rate limit", policy.rate_limit_n_per_s) *
            checked("the sample time", sample_time)),
      energy_(2 * checked("the power limit", policy.power_limit_w) *
              checked("the actuator's stiffness",
                      policy.power_limit_w ? policy.actuator_stiffness_n_per_m : 1.0) *
              sample_time) {}

bool Limits::apply(const Ref<const VectorXd>& last, std::int64_t n_samples,
                   Ref<VectorXd> force) const noexcept {
  const auto n = static_cast<double>(n_samples);
  bool limited = false;
  for (Index i = 0; i < force.size(); ++i) {
    const double before = last(i);
    double allowed = std::clamp(force(i), before - n * rate_, before + n * rate_);
    // Through zero the energy starts from nothing.
    const double held = before * allowed > 0 ? before * before : 0;
    const double largest =
        std::max(std::sqrt(held + n * energy_), held > 0 ? std::abs(before) : 0.0);
    allowed = std::clamp(allowed, -largest, largest);
    allowed = std::clamp(allowed, -force_, force_);
    limited |= allowed != force(i);
    force(i) = allowed;
  }
  return limited;
}

}  // namespace stillframe::controller
