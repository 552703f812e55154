#include "report/analysis/floor_samples.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stillframe::report {

using Eigen::Index;

FloorSamples::FloorSamples(const stillframe_msgs::run_info_t& info) : n_floor_(info.n_floor) {
  constexpr std::int64_t most_numbers = std::int64_t{1} << 19;
  most_ = std::max<std::int64_t>(1, most_numbers / std::max<std::int64_t>(1, n_floor_));
  every_ = 1 + std::max<std::int64_t>(0, info.n_samples - 1) / most_;
}

void FloorSamples::add(const SampleBlock& block) {
  const std::int64_t end = block.first_seq + block.n_samples();
  std::int64_t i = block.first_seq / every_ + (block.first_seq % every_ != 0 ? 1 : 0);
  for (; i < most_ && i * every_ < end; ++i) {
    const auto begin = static_cast<std::size_t>(i * n_floor_);
    values_.resize(begin, std::numeric_limits<double>::quiet_NaN());
    const auto row = block.floor_acceleration.row(static_cast<Index>(i * every_ - block.first_seq));
    values_.insert(values_.end(), row.begin(), row.end());
  }
}

bool FloorSamples::agrees(const FloorSamples& other) const {
  if (n_floor_ != other.n_floor_ || every_ != other.every_) return false;
  // Floors are the same to the bit, noise of their sensors too. Another machine may round
  // otherwise.
  constexpr double rounding = 1e-9;
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < std::min(values_.size(), other.values_.size()); ++i) {
    const double a = values_[i], b = other.values_[i];
    if (!std::isfinite(a) || !std::isfinite(b)) continue;
    difference = std::max(difference, std::abs(a - b));
    size = std::max({size, std::abs(a), std::abs(b)});
  }
  return difference <= rounding * size;
}

}  // namespace stillframe::report
