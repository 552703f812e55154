#include "report/analysis/level_track.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stillframe::report {

namespace {

/// What rms a Gaussian motion of this median level has; levels that are missing left out.
double usual(std::vector<double> levels) {
  std::erase_if(levels, [](double value) { return std::isnan(value); });
  if (levels.empty()) return 0;
  const auto middle = levels.begin() + static_cast<std::ptrdiff_t>(levels.size() / 2);
  std::nth_element(levels.begin(), middle, levels.end());
  constexpr double median_of_gaussian = 0.6745;  // of |x|, of unit variance
  return *middle / median_of_gaussian;
}

/// Root of the mean square of those that are there; 0 if none is.
double rms(const std::vector<double>& levels, std::size_t begin, std::size_t end) {
  double sum = 0;
  int n = 0;
  for (std::size_t i = begin; i < end; ++i) {
    if (std::isnan(levels[i])) continue;
    sum += levels[i] * levels[i];
    ++n;
  }
  return n > 0 ? std::sqrt(sum / n) : 0;
}

double largest(const std::vector<double>& values, std::size_t begin, std::size_t end) {
  double found = 0;
  for (std::size_t i = begin; i < end; ++i) {
    if (values[i] > found) found = values[i];  // never so for NaN
  }
  return found;
}

/// Where one of the signals is far above its usual level and what was before.
std::vector<bool> loud(const std::vector<double>& levels, const ShockCriteria& criteria) {
  const double limit = std::max(criteria.times_usual * usual(levels),
                                criteria.share_of_largest * largest(levels, 0, levels.size()));
  const auto back = static_cast<std::size_t>(std::lround(criteria.before_s / LevelTrack::step_s));
  std::vector<bool> result(levels.size());
  std::size_t rest = 0;  // behind the last that was loud
  for (std::size_t i = 0; i < levels.size(); ++i) {
    // Within a shock, what was before is what was before it.
    const std::size_t begin = std::max(rest, i > back ? i - back : 0);
    const bool goes_on = i > 0 && result[i - 1];
    result[i] =
        levels[i] > limit && (goes_on || levels[i] > criteria.times_before * rms(levels, begin, i));
    if (result[i]) rest = i + 1;
  }
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
                               double first_time_s, const ShockCriteria& criteria) {
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
  const auto back = static_cast<std::size_t>(std::lround(criteria.before_s / LevelTrack::step_s));
  std::vector<Shock> shocks;
  std::size_t rest_begin = 0;  // where the frame was at rest after the last shock
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
    Shock shock{.time_s = first_time_s + (static_cast<double>(peak) + 0.5) * LevelTrack::step_s,
                .floor_level = largest(floor, first, last + 1),
                .frame_level = largest(frame, first, end),
                .settling_s = {}};
    const double before = rms(frame, std::max(rest_begin, first > back ? first - back : 0), first);
    const double rest =
        std::max(criteria.rest_times_before * before, criteria.rest_share * shock.frame_level);
    // The first tenth from which on the frame is quiet for as long as levels are one shock.
    std::size_t settled = peak, quiet = peak;
    while (quiet < end && quiet < settled + apart) {
      if (!(frame[quiet] <= rest)) settled = quiet + 1;
      ++quiet;
    }
    if (settled < end) {
      shock.settling_s = static_cast<double>(settled - peak) * LevelTrack::step_s;
    }
    rest_begin = std::min(settled, end);
    shocks.push_back(shock);
  }
  return shocks;
}

}  // namespace stillframe::report
