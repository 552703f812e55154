#include "controller/sample_clock.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "msgs/clock.hpp"

namespace stillframe::controller {

namespace {

constexpr double slope_s = 10, first_late_s = 0.1, first_late_periods = 20;
constexpr double farthest_periods = 1e9;  // beyond it a number is no number of a sample

}  // namespace

SampleClock::SampleClock(std::int64_t start_ns, double sample_rate_hz, Pacing pacing,
                         std::int64_t start_doubt_ns)
    : nominal_ns_(ns_per_s / sample_rate_hz),
      period_ns_(nominal_ns_),
      pacing_(pacing),
      start_ns_(start_ns),
      reference_ns_(start_ns),
      most_shown_ns_(static_cast<double>(start_doubt_ns) +
                     std::max(first_late_s * ns_per_s, first_late_periods * nominal_ns_)) {
  if (!(sample_rate_hz > 0)) throw std::invalid_argument("SampleClock: no positive sample rate");
}

std::int64_t SampleClock::local_ns(std::int64_t time_ns) const noexcept {
  if (!disciplined()) return start_ns_ + time_ns;
  const double samples =
      static_cast<double>(time_ns) / nominal_ns_ - static_cast<double>(reference_);
  return reference_ns_ + std::llround(part_ns_ + samples * period_ns_);
}

double SampleClock::error_ns(std::int64_t seq, std::int64_t received_ns) const noexcept {
  return static_cast<double>(received_ns - reference_ns_) - part_ns_ -
         static_cast<double>(seq - reference_) * period_ns_;
}

void SampleClock::see(Measurement& measurement) noexcept {
  if (!disciplined()) return;
  const std::int64_t card = measurement.seq;
  std::int64_t seq = card + epoch_;
  // A datagram may come twice.
  if (keeps_numbers() && (seq <= last_ || (n_off_ > 0 && seq <= before_))) return;
  const double error = error_ns(seq, measurement.received_ns);
  const bool early = last_ - first_ < settle && error < 0 && error > -2 * period_ns_;
  const bool off = !(early || std::abs(error) < period_ns_ / 2) || seq <= last_;
  if (!locked_) {
    const double shows = static_cast<double>(measurement.received_ns - start_ns_) -
                         static_cast<double>(card) * nominal_ns_;
    if (keeps_numbers() && std::abs(shows) > most_shown_ns_) return;
    reference_ns_ = measurement.received_ns;
    lock(card, measurement.received_ns);
    locked_ = true;
    seq = card + epoch_;
  } else if (!off) {
    n_off_ = 0;
    track(seq, error);
  } else {
    n_off_ = n_off_ > 0 && card > before_ ? n_off_ + 1 : 1;
    before_ = card;
    if (n_off_ == 1) off_since_ns_ = measurement.received_ns;
    if (n_off_ == 1 || n_off_ == settle / 2 + 1) {
      least_off_before_ = least_off_;
      least_off_ = error;
    }
    least_off_ = std::min(least_off_, error);
    if (n_off_ == settle) {
      n_off_ = 0;
      const double lasted =
          static_cast<double>(measurement.received_ns - off_since_ns_) / period_ns_;
      const bool catches_up = least_off_ > 0 && least_off_before_ - least_off_ > period_ns_ / 4;
      if (lasted >= settle / 2.0 && !catches_up) {
        const auto by = admitted(seq, std::min(least_off_, least_off_before_));
        ++(by ? n_locks_ : n_held_);
        if (by) lock(card, measurement.received_ns - std::llround(error - *by));
        seq = card + epoch_;
      }
    }
  }
  if (pacing_ == Pacing::other_host) return;
  measurement.seq = seq;
  const double time_ns = static_cast<double>(seq) * nominal_ns_;
  measurement.time_ns =
      std::abs(time_ns) < farthest_periods * nominal_ns_ ? std::llround(time_ns) : -1;
}

void SampleClock::bound(std::int64_t earliest_ns, std::int64_t latest_ns) noexcept {
  bounded_ = keeps_numbers();
  earliest_ns_ = earliest_ns;
  latest_ns_ = latest_ns;
}

/// By how much the line moves at a sample where the arrivals say by (ns); none if it stays.
std::optional<double> SampleClock::admitted(std::int64_t seq, double by) const noexcept {
  if (!bounded_) return by;
  const auto beyond_line = [&](std::int64_t start_ns) {
    return static_cast<double>(start_ns - reference_ns_) - part_ns_ +
           static_cast<double>(reference_) * nominal_ns_ +
           static_cast<double>(seq - reference_) * (nominal_ns_ - period_ns_);
  };
  const double earliest = beyond_line(earliest_ns_);
  if (by > 0 ? earliest <= 0 : by < earliest) return std::nullopt;
  return std::min(by, beyond_line(latest_ns_) + period_ns_ / 2);
}

void SampleClock::track(std::int64_t seq, double error) noexcept {
  const std::int64_t n = seq - last_;
  last_ = seq;
  // The reference goes along, so that rounding stays below a ns however long it runs.
  const double moved = part_ns_ + static_cast<double>(seq - reference_) * period_ns_;
  part_ns_ = moved + std::min(error, most_drift * nominal_ns_ * static_cast<double>(n));
  const double whole = std::floor(part_ns_);
  reference_ns_ += static_cast<std::int64_t>(whole);
  part_ns_ -= whole;
  reference_ = seq;
  // Behind a gap or a lock the first arrivals are late ones, and the line may have gone along with
  // them.
  in_row_ = n > settle ? 0 : in_row_ + 1;
  if (in_row_ < settle) return;
  if (std::exchange(new_line_, false)) return begin_slope();
  const auto samples = static_cast<double>(reference_ - slope_from_);
  if (samples * nominal_ns_ < slope_s * ns_per_s) return;
  const double slope =
      (static_cast<double>(reference_ns_ - slope_ns_) + part_ns_ - slope_part_ns_) / samples;
  period_ns_ = nominal_ns_ * std::clamp(slope / nominal_ns_, 1 - most_drift, 1 + most_drift);
  begin_slope();
}

void SampleClock::begin_slope() noexcept {
  slope_ns_ = reference_ns_;
  slope_part_ns_ = part_ns_;
  slope_from_ = reference_;
}

// Of a card the line stays where it was to half a period, and with it the deadlines; what changes
// is which sample of the card belongs to which of its points.
void SampleClock::lock(std::int64_t card, std::int64_t taken_ns) noexcept {
  std::int64_t seq = card;
  if (pacing_ == Pacing::card) {
    const double since = (static_cast<double>(taken_ns - reference_ns_) - part_ns_) / period_ns_;
    seq = std::max<std::int64_t>(last_ + 1, reference_ + std::llround(since));
  } else {
    first_ = card;
  }
  epoch_ = seq - card;
  last_ = seq;
  reference_ = seq;
  reference_ns_ = taken_ns;
  part_ns_ = 0;
  in_row_ = 0;
  new_line_ = true;
}

}  // namespace stillframe::controller
