#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "controller/io.hpp"
#include "controller/policy.hpp"

namespace stillframe::controller {

/// Which measurements may be answered. Construction is set-up; the rest is hot: noexcept, no
/// allocation.
class Screen {
 public:
  Screen(const Policy& policy, double sample_rate_hz);

  /// True if a measurement of this age (s) is newer than all before, not from the future, and its
  /// number belongs to its time: not a duplicate, one that was overtaken, or one of another run
  /// played again.
  bool is_new(const Measurement& measurement, double age) noexcept;

  /// What is wrong with the newest measurement, of this age (s); none if nothing.
  Defect judge(const Measurement& measurement, double age) const noexcept;

 private:
  double sample_time_, late_after_, sigma_limit_;
  std::int64_t last_seq_ = -1;
};

}  // namespace stillframe::controller
