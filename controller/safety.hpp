#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>

namespace stillframe::controller {

/// What the loop allows the law to command: finite forces within a limit.
/// Construction is set-up; the rest is hot: noexcept, no allocation.
class Safety {
 public:
  /// force_limit: N, > 0, one for all legs; none means no limit. Errors: std::invalid_argument.
  explicit Safety(std::optional<double> force_limit);

  /// True if every value is finite.
  static bool is_finite(const Eigen::Ref<const Eigen::VectorXd>& values) noexcept;

  /// Limits every force (N) to plus or minus the limit; answers whether any was limited.
  bool saturate(Eigen::Ref<Eigen::VectorXd> force) const noexcept;

 private:
  double limit_ = std::numeric_limits<double>::infinity();
};

}  // namespace stillframe::controller
