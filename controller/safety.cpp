#include "controller/safety.hpp"

#include <stdexcept>
#include <string>

namespace stillframe::controller {

using Eigen::Ref;
using Eigen::VectorXd;

Safety::Safety(std::optional<double> force_limit) {
  if (!force_limit) return;
  if (!(*force_limit > 0)) {
    throw std::invalid_argument("Safety: the force limit must be positive, got " +
                                std::to_string(*force_limit));
  }
  limit_ = *force_limit;
}

bool Safety::is_finite(const Ref<const VectorXd>& values) noexcept { return values.allFinite(); }

bool Safety::saturate(Ref<VectorXd> force) const noexcept {
  bool limited = false;
  for (double& f : force) {
    if (f > limit_) {
      f = limit_;
      limited = true;
    } else if (f < -limit_) {
      f = -limit_;
      limited = true;
    }
  }
  return limited;
}

}  // namespace stillframe::controller
