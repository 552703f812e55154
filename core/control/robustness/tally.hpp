#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/control/robustness/evaluator.hpp"
#include "core/numerics/infinity.hpp"

namespace stillframe::robustness {

/// Counts of values in bins [k width, (k + 1) width), k whole; the first and the last bin also take
/// what lies beyond them.
struct Histogram {
  double width = 1;
  int first = 0, last = 0;
  std::map<int, std::uint64_t> counts;  ///< of bins that are not empty

  void add(double value);
  void merge(const Histogram& other);
  std::uint64_t total() const;
  /// Middle of the bin of the smallest value that a part `share` (0 to 1) of all does not exceed;
  /// NaN if there is none.
  double quantile(double share) const;
};

/// Counts of numbers of either sign and any size in bins of equal ratio, so that small ones are
/// known to as many digits as large ones: one histogram of log10(-value) and one of log10(value).
struct RatioHistogram {
  Histogram below, above;

  void add(double value);
  void merge(const RatioHistogram& other);
  std::uint64_t total() const { return below.total() + above.total(); }
  /// As Histogram::quantile, the middle by its ratio.
  double quantile(double share) const;
  /// The middles of the bins that are not empty, ascending, with their counts.
  std::vector<std::pair<double, std::uint64_t>> middles() const;
};

struct Extremes {
  double least = infinity;
  double most = -infinity;

  void add(double value);
  void merge(const Extremes& other);
};

/// By what plants are called worse than others: a larger spectral radius; less damping of the least
/// damped pole, or a higher peak of T, of stable loops.
enum class Measure { radius, damping, peak };
inline constexpr std::array measures{Measure::radius, Measure::damping, Measure::peak};

/// Larger for worse; infinite for damping and peak of an unstable loop, and minus infinity for what
/// failed.
double badness(const Outcome& outcome, Measure measure);

/// A sample worth remembering.
struct Case {
  std::uint64_t index = 0;
  Eigen::VectorXd values;  ///< p
  double radius = 0, damping = 0;
  double peak = 0;  ///< NaN of an unstable loop
};

/// What is kept of many outcomes. Tallies of disjoint sets of samples merge to exactly the tally of
/// their union, in any order: integers, extremes, and lists in an order of their own. Set-up.
struct Tally {
  static constexpr size_t n_worst = 10;

  std::uint64_t n_stable = 0, n_unstable = 0;
  std::map<std::string, std::uint64_t> failures;  ///< how many by why
  Extremes radius, damping, peak;                 ///< of all loops, of all loops, of stable loops
  Histogram decay;                                ///< log10 of the slowest decay in 1/s, if stable
  RatioHistogram least_damping;                   ///< of all loops
  Histogram peak_db;                              ///< of stable loops
  std::vector<Extremes> gain;                     ///< n_f, of stable loops, 1
  std::vector<Histogram> gain_db;                 ///< n_f
  std::vector<Extremes> highest;                  ///< n_f, of stable loops, 1
  std::vector<Histogram> highest_db;              ///< n_f
  /// The worst samples by each measure, worst first.
  std::array<std::vector<Case>, measures.size()> worst;

  /// An empty tally for n_f frequencies.
  explicit Tally(size_t n_frequencies);

  void add(std::uint64_t index, const Eigen::VectorXd& values, const Outcome& outcome);
  void merge(const Tally& other);

  std::uint64_t n_failed() const;
  std::uint64_t n_samples() const { return n_stable + n_unstable + n_failed(); }
};

}  // namespace stillframe::robustness
