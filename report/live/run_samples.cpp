#include "report/live/run_samples.hpp"

#include <algorithm>
#include <cmath>

namespace stillframe::live {

using Eigen::Index;
using stillframe_msgs::command_t;
using stillframe_msgs::measurement_t;

namespace {

// 32 MB; a run of so many and such fast channels that 16 s are more is seen through less.
constexpr Index most_values = Index{1} << 22;
constexpr double lowest_rate_hz = 0.1, highest_rate_hz = 1e7;
// Measurements that overtake each other do so by a few; more in a row are a run begun again.
constexpr std::int64_t restart_after = 20;
// A command answers a measurement that has been there; it may come here a little earlier than that.
constexpr std::int64_t command_ahead = 1000;

/// The roundest rate that explains a time of k samples to its 1 ns.
double rate_of(std::int64_t k, std::int64_t time_ns) {
  const double rate = static_cast<double>(k) * 1e9 / static_cast<double>(time_ns);
  const double uncertain = rate / static_cast<double>(time_ns);
  for (const double digits : {1., 10., 100., 1000.}) {
    const double rounded = std::round(rate * digits) / digits;
    if (std::abs(rounded - rate) <= uncertain) return rounded;
  }
  return rate;
}

bool is_possible(double rate_hz) { return rate_hz >= lowest_rate_hz && rate_hz <= highest_rate_hz; }

}  // namespace

RunSamples::RunSamples(int n_floor, int n_legs, int n_frame, std::optional<double> sample_rate_hz)
    : n_floor_(n_floor), n_legs_(n_legs), n_frame_(n_frame) {
  const double rate = sample_rate_hz.value_or(0);
  if (is_possible(rate)) {
    rate_ = rate;
    make_windows();
  }
}

void RunSamples::make_windows() {
  const auto wanted = static_cast<Index>(std::lround(window_s * rate_));
  const auto make = [wanted](int n_channels) {
    const Index most = most_values / std::max(n_channels, 1);
    return RollingWindow(n_channels, std::clamp<Index>(wanted, 2, std::max<Index>(most, 2)));
  };
  motion_ = make(n_floor_ + n_frame_);
  force_ = make(n_legs_);
}

void RunSamples::find_rate(const measurement_t& message) {
  if (message.seq <= 0 || message.time_ns <= 0) return;
  const double rate = rate_of(message.seq, message.time_ns);
  if (!is_possible(rate)) return;
  rate_ = rate;
  make_windows();
}

double RunSamples::time_of(std::int64_t seq, std::int64_t time_ns) const noexcept {
  return rate_ > 0 ? static_cast<double>(seq) / rate_ : static_cast<double>(time_ns) * 1e-9;
}

bool RunSamples::fits(const measurement_t& message) const noexcept {
  return message.n_floor == n_floor_ && message.n_legs == n_legs_ && message.n_frame == n_frame_;
}

void RunSamples::clean(std::vector<double>& values, const RollingWindow& window) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) continue;
    values[i] = window.size() > 0 ? window.last(static_cast<Index>(i)) : 0;
    ++n_not_finite_;
  }
}

RunSamples::Taken RunSamples::take(const measurement_t& message) {
  if (!fits(message)) return Taken::wrong_size;
  if (message.seq <= seq_) {
    // The plant of a lock-step run repeats its newest measurement until it is answered.
    const bool rises = message.seq > behind_seq_;
    if (message.seq < seq_) n_behind_ = rises ? n_behind_ + 1 : 0;
    behind_seq_ = message.seq;
    return n_behind_ >= restart_after ? Taken::restarted : Taken::old;
  }
  n_behind_ = 0;
  behind_seq_ = -1;
  const std::int64_t missed = seq_ < 0 ? 0 : message.seq - seq_ - 1;
  seq_ = message.seq;
  if (rate_ == 0) find_rate(message);
  time_s_ = time_of(message.seq, message.time_ns);
  n_missed_ += missed;
  if (missed > 0) gap_seq_ = seq_;
  row_ = message.floor_acceleration;
  row_.insert(row_.end(), message.frame_acceleration.begin(), message.frame_acceleration.end());
  clean(row_, motion_);

  Bucket& bucket = bucket_at(time_s_);
  ++bucket.n;
  for (std::size_t i = 0; i < row_.size(); ++i) bucket.sum_squares[i] += row_[i] * row_[i];

  if (rate_ == 0) return Taken::fresh;
  if (missed > 0) bridge(missed);
  motion_.push(row_);
  return Taken::fresh;
}

void RunSamples::bridge(std::int64_t n) {
  if (motion_.size() == 0) return;
  if (static_cast<double>(n) > bridged_s * rate_) {
    motion_.clear();
    began_anew_ = true;
    return;
  }
  std::vector<double> before(row_.size()), between(row_.size());
  for (std::size_t i = 0; i < row_.size(); ++i) before[i] = motion_.last(static_cast<Index>(i));
  for (std::int64_t k = 1; k <= n; ++k) {
    const double part = static_cast<double>(k) / static_cast<double>(n + 1);
    for (std::size_t i = 0; i < row_.size(); ++i) between[i] = std::lerp(before[i], row_[i], part);
    motion_.push(between);
  }
}

bool RunSamples::take(const command_t& message) {
  if (message.n_legs != n_legs_) return false;
  if (message.seq <= command_seq_) return true;
  if (seq_ >= 0 && message.seq - seq_ > command_ahead) return true;
  command_seq_ = message.seq;
  n_saturated_ += message.saturated ? 1 : 0;
  std::vector<double> force = message.force;
  clean(force, force_);
  Bucket& bucket = bucket_at(time_of(message.seq, message.time_ns));
  for (std::size_t i = 0; i < force.size(); ++i) {
    bucket.largest_force[i] = std::max(bucket.largest_force[i], std::abs(force[i]));
  }
  if (force_.capacity() > 0) force_.push(force);
  return true;
}

// What is older than the newest bucket goes into the newest.
Bucket& RunSamples::bucket_at(double time_s) {
  const auto number =
      static_cast<std::int64_t>(std::floor(std::clamp(time_s / bucket_s, 0., 1e15)));
  if (history_.empty() || number > history_.back().number) {
    if (history_.size() == n_buckets) history_.pop_front();
    history_.push_back(
        {.number = number,
         .n = 0,
         .sum_squares = std::vector<double>(static_cast<std::size_t>(n_floor_ + n_frame_)),
         .largest_force = std::vector<double>(static_cast<std::size_t>(n_legs_))});
  }
  return history_.back();
}

}  // namespace stillframe::live
