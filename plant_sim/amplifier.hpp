#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace stillframe {

/// The simulated amplifiers. When no command comes they hold the last force F_h for hold_samples,
/// and then let it go to zero within fade_s; when commands c come again after that, they come back
/// to them from where they are, F_b. Both smoothly, because a step kicks the frame:
///   F = F_h (1 - s(t / fade_s)),   F = c + (F_b - c_b) (1 - s(t / fade_s)).
/// Source: docs/safety.md. Construction is set-up; the rest is hot: noexcept, no allocation.
class Amplifier {
 public:
  /// Errors: std::invalid_argument if hold_samples is negative or a time is not positive.
  Amplifier(Eigen::Index n_legs, std::int64_t hold_samples, double fade_s, double sample_time);

  /// The force (n_legs, N) of the next sample, from the newest command and how many samples ago a
  /// newer one was due (0 or less: it is the newest that can be).
  const Eigen::VectorXd& drive(const Eigen::Ref<const Eigen::VectorXd>& command,
                               std::int64_t n_missing) noexcept;

 private:
  /// What is left of a force or of a difference, t (samples) after its beginning.
  double left(std::int64_t n_samples) const noexcept;

  std::int64_t hold_samples_, since_ = 0;
  double sample_time_, fade_s_;
  bool faded_ = false;
  Eigen::VectorXd force_, held_, difference_;  ///< n_legs, N
};

}  // namespace stillframe
