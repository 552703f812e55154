#include "tools/robustness_spread.hpp"

#include <algorithm>
#include <cmath>

#include "core/mechanics/frequency_response.hpp"
#include "core/systems/frequency_range.hpp"
#include "tools/robustness_text.hpp"

namespace stillframe::tools {

using Eigen::Index;
using Eigen::VectorXd;
using robustness::Evaluator;
using robustness::Record;
using robustness::Tally;

Spread::Spread(const Record& record) {
  const Tally& tally = record.tally;
  const VectorXd& f = record.frequencies_hz;
  const double half_rate = 0.5 / record.sample_time;
  for (Index i = 0; i < f.size(); ++i) {
    const auto at = static_cast<size_t>(i);
    const robustness::Extremes extremes = in_decibels(tally.highest[at]);
    const auto quantile = [&](double share) {
      return quantile_within(tally.highest_db[at], extremes, share);
    };
    const auto add = [&](double hz) {
      nodes_hz_.push_back(hz);
      low_db_.push_back(quantile(0.05));
      high_db_.push_back(quantile(0.95));
      most_db_.push_back(extremes.most);
    };
    if (tally.highest_db[at].counts == tally.gain_db[at].counts) {
      add(f(i));
      continue;
    }
    // A hair apart from the end of what the neighbour has level.
    constexpr double hair = 1e-6;
    add(i == 0 ? f(i) : std::sqrt(f(i) * f(i - 1)) * (1 + hair));
    add(i + 1 == f.size() ? half_rate : std::sqrt(f(i) * f(i + 1)) * (1 - hair));
  }
}

VectorXd Spread::along(const VectorXd& frequencies_hz, const std::vector<double>& values_db) const {
  VectorXd found(frequencies_hz.size());
  for (Index i = 0; i < found.size(); ++i) {
    const double hz = frequencies_hz(i);
    const auto above = std::lower_bound(nodes_hz_.begin(), nodes_hz_.end(), hz);
    const auto at = static_cast<size_t>(above - nodes_hz_.begin());
    double db = above == nodes_hz_.end() ? values_db.back() : values_db[at];
    if (above != nodes_hz_.end() && at > 0) {
      const double part = std::log(hz / nodes_hz_[at - 1]) / std::log(*above / nodes_hz_[at - 1]);
      db = values_db[at - 1] + part * (values_db[at] - values_db[at - 1]);
    }
    found(i) = std::pow(10, db / 20);
  }
  return found;
}

VectorXd Spread::low(const VectorXd& frequencies_hz) const {
  return along(frequencies_hz, low_db_);
}
VectorXd Spread::high(const VectorXd& frequencies_hz) const {
  return along(frequencies_hz, high_db_);
}
VectorXd Spread::most(const VectorXd& frequencies_hz) const {
  return along(frequencies_hz, most_db_);
}

VectorXd frequencies_of(const Evaluator& evaluator, const std::vector<VectorXd>& plants,
                        const Spread& spread) {
  constexpr Index n_even = 400;
  const std::vector<double>& nodes = spread.nodes_hz();
  const VectorXd even = logarithmic_frequencies(nodes.front(), nodes.back(), n_even);
  std::vector<double> all(nodes);
  for (const VectorXd& plant : plants) {
    const VectorXd shown = evaluator.curve(plant, even, true).frequencies_hz;
    all.insert(all.end(), shown.begin(), shown.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  // The logarithm of an end is rounded.
  std::erase_if(all, [&](double hz) { return hz < nodes.front() || hz > nodes.back(); });
  return Eigen::Map<VectorXd>(all.data(), static_cast<Index>(all.size()));
}

DampingBars damping_bars(const Tally& tally, double nominal) {
  const auto samples = static_cast<double>(tally.n_samples());
  const robustness::RatioHistogram& histogram = tally.least_damping;
  if (histogram.total() == 0) return {};
  const double least = std::min(tally.damping.least, nominal),
               most = std::max(tally.damping.most, nominal);
  const double bin = std::pow(10, histogram.above.width) - 1;
  const double narrowest = 2 * bin * std::max(std::abs(least), std::abs(most));
  DampingBars bars{.width = rounded_up(std::max({(most - least) / 30, narrowest, 1e-9})),
                   .shares = {}};
  for (const auto& [middle, count] : histogram.middles()) {
    const double value = std::clamp(middle, tally.damping.least, tally.damping.most);
    bars.shares[bars.width * std::floor(value / bars.width)] +=
        static_cast<double>(count) / samples;
  }
  return bars;
}

}  // namespace stillframe::tools
