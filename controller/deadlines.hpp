#pragma once

#include <cstdint>

namespace stillframe::controller {

/// Absolute deadlines t_0 + (k + phase) T, k = 0, 1, ..., that keep their phase however late a
/// wake-up is. Times in ns on one clock. Construction is set-up; the rest is hot: noexcept, no
/// allocation.
class Deadlines {
 public:
  /// What a wake-up was like.
  struct WakeUp {
    std::int64_t past_deadline_ns = 0;
    std::int64_t n_skipped = 0;  ///< whole periods that went by meanwhile
  };

  /// rate_hz > 0; phase in [0, 1), as a part of a period. Errors: std::invalid_argument.
  Deadlines(std::int64_t start_ns, double rate_hz, double phase);

  /// The deadline to sleep until.
  std::int64_t next_ns() const noexcept { return deadline_ns(k_); }

  /// Takes the wake-up at now_ns (not before next_ns) and moves to the first deadline after it.
  WakeUp wake_up(std::int64_t now_ns) noexcept;

  /// Begins anew, with k = reference at reference_ns, at the first deadline after now_ns.
  void begin(std::int64_t reference_ns, std::int64_t reference, std::int64_t now_ns) noexcept;
  /// From here on: the instant of k = reference is reference_ns, and a period period_ns.
  void follow(std::int64_t reference_ns, std::int64_t reference, double period_ns) noexcept;

 private:
  std::int64_t deadline_ns(std::int64_t k) const noexcept;

  std::int64_t reference_ns_, reference_ = 0, k_ = 0;
  double period_ns_, phase_;
};

}  // namespace stillframe::controller
