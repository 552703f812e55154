#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace stillframe {

/// The simulated amplifiers when no command comes: they hold the last force for hold_samples, and
/// then let it go to zero within fade_s, smoothly, because a force that is dropped at once kicks
/// the frame. Source: docs/safety.md. Construction is set-up; the rest is hot: noexcept, no
/// allocation.
class Amplifier {
 public:
  /// Errors: std::invalid_argument if hold_samples is negative or a time is not positive.
  Amplifier(std::int64_t hold_samples, double fade_s, double sample_time);

  /// The part of the last force, 0 to 1, that still acts n_samples after it was due anew.
  double part(std::int64_t n_samples) const noexcept;

 private:
  std::int64_t hold_samples_;
  double sample_time_, fade_s_;
};

}  // namespace stillframe
