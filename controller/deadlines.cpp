#include "controller/deadlines.hpp"

#include <cmath>
#include <stdexcept>

#include "msgs/clock.hpp"

namespace stillframe::controller {

Deadlines::Deadlines(std::int64_t start_ns, double rate_hz, double phase)
    : start_ns_(start_ns), period_ns_(ns_per_s / rate_hz), phase_(phase) {
  if (!(rate_hz > 0)) throw std::invalid_argument("Deadlines: rate_hz must be positive");
  if (!(phase >= 0 && phase < 1)) throw std::invalid_argument("Deadlines: phase must be in [0, 1)");
}

Deadlines::WakeUp Deadlines::wake_up(std::int64_t now_ns) noexcept {
  const WakeUp result{
      .past_deadline_ns = now_ns - next_ns(),
      .n_skipped = static_cast<std::int64_t>(static_cast<double>(now_ns - next_ns()) / period_ns_)};
  k_ += result.n_skipped + 1;
  return result;
}

// From k each time, and not by adding periods up: a rate that is no whole number of ns does not
// drift.
std::int64_t Deadlines::deadline_ns(std::int64_t k) const noexcept {
  return start_ns_ + std::llround((static_cast<double>(k) + phase_) * period_ns_);
}

}  // namespace stillframe::controller
