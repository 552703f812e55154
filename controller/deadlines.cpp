#include "controller/deadlines.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "msgs/clock.hpp"

namespace stillframe::controller {

Deadlines::Deadlines(std::int64_t start_ns, double rate_hz, double phase)
    : reference_ns_(start_ns), period_ns_(ns_per_s / rate_hz), phase_(phase) {
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

void Deadlines::begin(std::int64_t reference_ns, std::int64_t reference,
                      std::int64_t now_ns) noexcept {
  reference_ns_ = reference_ns;
  reference_ = reference;
  const double periods = static_cast<double>(now_ns - reference_ns) / period_ns_ - phase_;
  k_ = reference + std::max<std::int64_t>(0, static_cast<std::int64_t>(std::floor(periods)) + 1);
}

void Deadlines::follow(std::int64_t reference_ns, std::int64_t reference,
                       double period_ns) noexcept {
  reference_ns_ = reference_ns;
  reference_ = reference;
  period_ns_ = period_ns;
}

// From k each time, and not by adding periods up: a rate that is no whole number of ns does not
// drift.
std::int64_t Deadlines::deadline_ns(std::int64_t k) const noexcept {
  return reference_ns_ + std::llround((static_cast<double>(k - reference_) + phase_) * period_ns_);
}

}  // namespace stillframe::controller
