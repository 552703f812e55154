#include "controller/screen.hpp"

#include <algorithm>
#include <cmath>

namespace stillframe::controller {

namespace {

// m/s^2 or rad/s^2: no floor that a frame stands on.
constexpr double most_floor = 1e3;

}  // namespace

Screen::Screen(const Policy& policy, double sample_rate_hz)
    : sample_time_(1 / sample_rate_hz),
      late_after_(policy.late_periods / sample_rate_hz),
      sigma_limit_(policy.sigma_limit_n) {}

bool Screen::is_new(const Measurement& measurement, double age) noexcept {
  if (measurement.seq <= last_seq_) return false;
  // One from the future would make all until then look like old ones.
  if (age < -sample_time_) return false;
  const double due = static_cast<double>(measurement.seq) * sample_time_;
  if (std::abs(static_cast<double>(measurement.time_ns) * 1e-9 - due) > sample_time_ / 2) {
    return false;
  }
  last_seq_ = measurement.seq;
  return true;
}

Defect Screen::judge(const Measurement& measurement, double age) const noexcept {
  if (age > late_after_) return Defect::late;
  if (!measurement.sigma.allFinite() || !measurement.applied.allFinite() ||
      !measurement.floor.allFinite()) {
    return Defect::not_finite;
  }
  if ((measurement.sigma.array().abs() > sigma_limit_).any() ||
      (measurement.applied.array().abs() > sigma_limit_).any() ||
      (measurement.floor.array().abs() > most_floor).any()) {
    return Defect::out_of_range;
  }
  return Defect::none;
}

}  // namespace stillframe::controller
