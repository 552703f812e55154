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
  /// start_ns: t_0 on CLOCK_MONOTONIC, from which time_ns of a measurement counts.
  Screen(const Policy& policy, double sample_rate_hz, std::int64_t start_ns);

  /// True if a measurement is newer than all before, not from the future of now_ns
  /// (CLOCK_MONOTONIC), and its number belongs to its time: not a duplicate, one that was
  /// overtaken, or one of another run played again.
  bool is_new(const Measurement& measurement, std::int64_t now_ns) noexcept;

  /// What is wrong with the newest measurement, seen at now_ns; none if nothing.
  Defect judge(const Measurement& measurement, std::int64_t now_ns) noexcept;

  /// s from the sample to now.
  double age(const Measurement& measurement, std::int64_t now_ns) const noexcept {
    return static_cast<double>(now_ns - start_ns_ - measurement.time_ns) * 1e-9;
  }

 private:
  double sample_time_, late_after_, sigma_limit_;
  std::int64_t start_ns_, last_seq_ = -1;
};

}  // namespace stillframe::controller
