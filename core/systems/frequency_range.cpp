#include "core/systems/frequency_range.hpp"

#include <algorithm>
#include <cmath>

#include "core/numerics/infinity.hpp"

namespace stillframe {

using Eigen::Index;

namespace {

/// A frame on its legs has six, and a flexible one some more that matter. What a finely divided
/// beam has beyond is no reason to show a megahertz.
constexpr Index most_modes = 12;

/// The i-th of ..., 1, 2, 5, 10, ...
double round_number(int i) {
  constexpr double steps[] = {1, 2, 5};
  const int decade = static_cast<int>(std::floor(i / 3.0));
  const double step = steps[i - 3 * decade];
  // By division, so that 0.05 is the number that is written so.
  return decade < 0 ? step / std::pow(10.0, -decade) : step * std::pow(10.0, decade);
}

/// The largest i with round_number(i) <= x; x > 0. A number that rounding moved counts as itself.
int round_number_below(double x) {
  x *= 1 + 1e-9;
  int i = 3 * static_cast<int>(std::floor(std::log10(x))) - 1;
  while (round_number(i + 1) <= x) ++i;
  return i;
}

}  // namespace

double rounded_up(double x) {
  const int below = round_number_below(x);
  return round_number(below) >= x * (1 - 1e-9) ? round_number(below) : round_number(below + 1);
}

FrequencyRange frequency_range(const Eigen::VectorXd& own_hz, const std::vector<double>& targets_hz,
                               double sample_rate_hz) {
  double slowest = infinity, fastest = 0;
  const auto include = [&](double hz) {
    slowest = std::min(slowest, hz);
    fastest = std::max(fastest, hz);
  };
  for (const double hz : own_hz.head(std::min(own_hz.size(), most_modes))) include(hz);
  for (const double hz : targets_hz) include(hz);
  const bool sampled = sample_rate_hz > 0;
  if (fastest == 0) {
    return sampled ? FrequencyRange{sample_rate_hz / 2000, sample_rate_hz / 2}
                   : FrequencyRange{0.1, 1000};
  }
  FrequencyRange range{round_number(round_number_below(slowest / 10)), rounded_up(4 * fastest)};
  if (sampled) range.highest_hz = std::min(range.highest_hz, sample_rate_hz / 2);
  range.lowest_hz = std::min(range.lowest_hz, range.highest_hz / 10);
  return range;
}

std::vector<double> round_frequencies(const FrequencyRange& range) {
  std::vector<double> found;
  int i = round_number_below(range.lowest_hz);
  if (round_number(i) < range.lowest_hz * (1 - 1e-9)) ++i;
  for (; round_number(i) <= range.highest_hz * (1 + 1e-9); ++i) found.push_back(round_number(i));
  return found;
}

}  // namespace stillframe
