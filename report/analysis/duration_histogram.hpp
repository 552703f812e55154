#pragma once

#include <cstdint>
#include <vector>

namespace stillframe::report {

/// How often a duration fell between edges that are ten to a decade, from 10 ns to 10 s; what is
/// outside falls into the first or the last bin.
class DurationHistogram {
 public:
  DurationHistogram();
  void add(std::int64_t duration_ns);

  std::int64_t count() const { return count_; }
  std::int64_t largest_ns() const { return largest_ns_; }
  /// The upper edge of the bin that holds the p-th part, in microseconds; p in 0 to 1.
  double quantile_us(double p) const;
  /// n + 1 rising edges in microseconds and the n counts between them.
  const std::vector<double>& edges_us() const { return edges_us_; }
  const std::vector<std::int64_t>& counts() const { return counts_; }

 private:
  std::vector<double> edges_us_;
  std::vector<std::int64_t> counts_;
  std::int64_t count_ = 0, largest_ns_ = 0;
};

}  // namespace stillframe::report
