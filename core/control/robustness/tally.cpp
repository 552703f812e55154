#include "core/control/robustness/tally.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/numerics/decibels.hpp"
#include "core/numerics/infinity.hpp"

namespace stillframe::robustness {

void Histogram::add(double value) {
  const double bin = std::floor(value / width);
  ++counts[bin <= first ? first : bin >= last ? last : static_cast<int>(bin)];
}

void Histogram::merge(const Histogram& other) {
  for (const auto& [bin, count] : other.counts) counts[bin] += count;
}

std::uint64_t Histogram::total() const {
  std::uint64_t sum = 0;
  for (const auto& [bin, count] : counts) sum += count;
  return sum;
}

double Histogram::quantile(double share) const {
  const double wanted = share * static_cast<double>(total());
  std::uint64_t sum = 0;
  for (const auto& [bin, count] : counts) {
    sum += count;
    if (static_cast<double>(sum) >= wanted) return (bin + 0.5) * width;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

void RatioHistogram::add(double value) {
  (value > 0 ? above : below).add(std::log10(std::abs(value)));
}

void RatioHistogram::merge(const RatioHistogram& other) {
  below.merge(other.below);
  above.merge(other.above);
}

std::vector<std::pair<double, std::uint64_t>> RatioHistogram::middles() const {
  std::vector<std::pair<double, std::uint64_t>> found;
  const auto middle = [](const Histogram& histogram, int bin) {
    return std::pow(10, (bin + 0.5) * histogram.width);
  };
  for (auto bin = below.counts.rbegin(); bin != below.counts.rend(); ++bin) {
    found.emplace_back(-middle(below, bin->first), bin->second);
  }
  for (const auto& [bin, count] : above.counts) found.emplace_back(middle(above, bin), count);
  return found;
}

double RatioHistogram::quantile(double share) const {
  const double wanted = share * static_cast<double>(total());
  std::uint64_t sum = 0;
  for (const auto& [middle, count] : middles()) {
    sum += count;
    if (static_cast<double>(sum) >= wanted) return middle;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

void Extremes::add(double value) {
  least = std::min(least, value);
  most = std::max(most, value);
}

void Extremes::merge(const Extremes& other) {
  least = std::min(least, other.least);
  most = std::max(most, other.most);
}

double badness(const Outcome& outcome, Measure measure) {
  if (outcome.verdict == Outcome::Verdict::failed) return -infinity;
  if (measure == Measure::radius) return outcome.radius;
  if (outcome.verdict == Outcome::Verdict::unstable) return infinity;
  return measure == Measure::damping ? -outcome.damping : outcome.peak;
}

namespace {

double badness(const Case& sample, Measure measure) {
  return measure == Measure::radius    ? sample.radius
         : measure == Measure::damping ? -sample.damping
                                       : sample.peak;
}

/// Puts a sample where it belongs; of equally bad ones the first comes first.
void insert(std::vector<Case>& list, const Case& sample, Measure measure) {
  const auto worse = [measure](const Case& a, const Case& b) {
    const double bad_a = badness(a, measure), bad_b = badness(b, measure);
    return bad_a != bad_b ? bad_a > bad_b : a.index < b.index;
  };
  const auto place = std::upper_bound(list.begin(), list.end(), sample, worse);
  if (static_cast<size_t>(place - list.begin()) >= Tally::n_worst) return;
  list.insert(place, sample);
  if (list.size() > Tally::n_worst) list.pop_back();
}

constexpr double db_width = 0.05;
constexpr int db_last = 4000;  // 200 dB either way
/// 0.23 %, from 1e-9 to 1.
const Histogram damping_ratios{.width = 0.001, .first = -9000, .last = 0, .counts = {}};

}  // namespace

Tally::Tally(size_t n_frequencies)
    : decay{.width = 0.02, .first = -500, .last = 300, .counts = {}},
      least_damping{.below = damping_ratios, .above = damping_ratios},
      peak_db{.width = db_width, .first = -db_last, .last = db_last, .counts = {}},
      gain(n_frequencies),
      gain_db(n_frequencies, peak_db),
      highest(n_frequencies),
      highest_db(n_frequencies, peak_db) {}

void Tally::add(std::uint64_t index, const Eigen::VectorXd& values, const Outcome& outcome) {
  if (outcome.verdict == Outcome::Verdict::failed) {
    ++failures[outcome.failure];
    return;
  }
  const bool stable = outcome.verdict == Outcome::Verdict::stable;
  ++(stable ? n_stable : n_unstable);
  radius.add(outcome.radius);
  damping.add(outcome.damping);
  least_damping.add(outcome.damping);
  const Case sample{index, values, outcome.radius, outcome.damping,
                    stable ? outcome.peak : std::numeric_limits<double>::quiet_NaN()};
  for (const Measure measure : measures) {
    if (measure != Measure::radius && !stable) continue;
    insert(worst[static_cast<size_t>(measure)], sample, measure);
  }
  if (!stable) return;
  decay.add(std::log10(outcome.decay));
  peak.add(outcome.peak);
  peak_db.add(decibels(outcome.peak));
  for (size_t i = 0; i < gain.size(); ++i) {
    const double value = outcome.gain(static_cast<Eigen::Index>(i));
    gain[i].add(value);
    gain_db[i].add(decibels(value));
    const double most = outcome.highest(static_cast<Eigen::Index>(i));
    highest[i].add(most);
    highest_db[i].add(decibels(most));
  }
}

void Tally::merge(const Tally& other) {
  if (other.gain.size() != gain.size()) {
    throw std::invalid_argument("Tally::merge: tallies of different frequencies");
  }
  n_stable += other.n_stable;
  n_unstable += other.n_unstable;
  for (const auto& [why, count] : other.failures) failures[why] += count;
  radius.merge(other.radius);
  damping.merge(other.damping);
  peak.merge(other.peak);
  decay.merge(other.decay);
  least_damping.merge(other.least_damping);
  peak_db.merge(other.peak_db);
  for (size_t i = 0; i < gain.size(); ++i) {
    gain[i].merge(other.gain[i]);
    gain_db[i].merge(other.gain_db[i]);
    highest[i].merge(other.highest[i]);
    highest_db[i].merge(other.highest_db[i]);
  }
  for (const Measure measure : measures) {
    const auto m = static_cast<size_t>(measure);
    for (const Case& sample : other.worst[m]) insert(worst[m], sample, measure);
  }
}

std::uint64_t Tally::n_failed() const {
  std::uint64_t sum = 0;
  for (const auto& [why, count] : failures) sum += count;
  return sum;
}

}  // namespace stillframe::robustness
