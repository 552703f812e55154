#include "report/analysis/level_track.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stillframe::report {

namespace {

/// The level that so large a share of the levels is below.
double quantile(std::vector<double> values, double share) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty()) return 0;
  const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<std::size_t>(place)];
}

double largest(const std::vector<double>& values, std::size_t begin, std::size_t end) {
  double found = 0;
  for (std::size_t i = begin; i < end; ++i) {
    if (values[i] > found) found = values[i];  // never so for NaN
  }
  return found;
}

/// Where one of the signals is far above its usual level.
std::vector<bool> loud(const std::vector<double>& levels, const ShockCriteria& criteria) {
  const double limit = std::max(criteria.times_median * quantile(levels, 0.5),
                                criteria.share_of_largest * largest(levels, 0, levels.size()));
  std::vector<bool> result(levels.size());
  for (std::size_t i = 0; i < levels.size(); ++i) result[i] = levels[i] > limit;
  return result;
}

}  // namespace

LevelTrack::LevelTrack(double sample_rate_hz) : samples_per_step_(sample_rate_hz * step_s) {}

void LevelTrack::close() {
  levels_.push_back(in_step_ > 0 ? std::sqrt(sum_ / static_cast<double>(in_step_))
                                 : std::numeric_limits<double>::quiet_NaN());
  sum_ = 0;
  in_step_ = 0;
}

void LevelTrack::add(const Eigen::Ref<const Eigen::VectorXd>& x) {
  for (const double value : x) {
    sum_ += value * value;
    ++in_step_;
    ++next_;
    if (static_cast<double>(next_) >= samples_per_step_ * static_cast<double>(levels_.size() + 1)) {
      close();
    }
  }
}

void LevelTrack::skip(std::int64_t n) {
  next_ += n;
  while (static_cast<double>(next_) >=
         samples_per_step_ * static_cast<double>(levels_.size() + 1)) {
    close();
  }
}

std::vector<Shock> find_shocks(const std::vector<double>& floor, const std::vector<double>& frame,
                               const ShockCriteria& criteria) {
  const std::size_t n = std::min(floor.size(), frame.size());
  const auto floor_loud = loud(floor, criteria), frame_loud = loud(frame, criteria);
  const auto apart = static_cast<std::size_t>(std::lround(criteria.apart_s / LevelTrack::step_s));
  // First and last loud step of each.
  std::vector<std::pair<std::size_t, std::size_t>> spans;
  for (std::size_t i = 0; i < n; ++i) {
    if (!floor_loud[i] && !frame_loud[i]) continue;
    if (!spans.empty() && i - spans.back().second <= apart) {
      spans.back().second = i;
    } else {
      spans.emplace_back(i, i);
    }
  }
  const double quiet = quantile(frame, 0.1);
  std::vector<Shock> shocks;
  for (std::size_t s = 0; s < spans.size(); ++s) {
    const auto [first, last] = spans[s];
    const std::size_t end = s + 1 < spans.size() ? spans[s + 1].first : n;
    // The cause is where the floor is loudest, or the frame if the floor has no part in it.
    const bool by_floor = std::any_of(floor_loud.begin() + static_cast<std::ptrdiff_t>(first),
                                      floor_loud.begin() + static_cast<std::ptrdiff_t>(last) + 1,
                                      [](bool is) { return is; });
    const std::vector<double>& cause = by_floor ? floor : frame;
    std::size_t peak = first;
    for (std::size_t i = first; i <= last; ++i) {
      if (cause[i] > cause[peak] || std::isnan(cause[peak])) peak = i;
    }
    Shock shock{.time_s = (static_cast<double>(peak) + 0.5) * LevelTrack::step_s,
                .floor_level = largest(floor, first, last + 1),
                .frame_level = largest(frame, first, end),
                .settling_s = {}};
    const double rest =
        std::max(criteria.rest_times_quiet * quiet, criteria.rest_share * shock.frame_level);
    std::size_t settled = end;
    while (settled > peak && !(frame[settled - 1] > rest)) --settled;
    if (settled < end) {
      shock.settling_s = static_cast<double>(settled - peak) * LevelTrack::step_s;
    }
    shocks.push_back(shock);
  }
  return shocks;
}

}  // namespace stillframe::report
