#include "report/analysis/duration_histogram.hpp"

#include <algorithm>
#include <cmath>

namespace stillframe::report {

namespace {
constexpr int per_decade = 10, first_decade = -2, n_decades = 9;  // of a microsecond
}

DurationHistogram::DurationHistogram() : counts_(per_decade * n_decades, 0) {
  for (int i = 0; i <= per_decade * n_decades; ++i) {
    edges_us_.push_back(std::pow(10.0, first_decade + static_cast<double>(i) / per_decade));
  }
}

void DurationHistogram::add(std::int64_t duration_ns) {
  const double us = 1e-3 * static_cast<double>(duration_ns);
  const auto above = std::upper_bound(edges_us_.begin(), edges_us_.end(), us);
  const auto bin = std::clamp<std::ptrdiff_t>(above - edges_us_.begin() - 1, 0,
                                              static_cast<std::ptrdiff_t>(counts_.size()) - 1);
  ++counts_[static_cast<std::size_t>(bin)];
  ++count_;
  largest_ns_ = std::max(largest_ns_, duration_ns);
}

double DurationHistogram::quantile_us(double p) const {
  double passed = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    passed += static_cast<double>(counts_[i]);
    if (passed >= p * static_cast<double>(count_)) return edges_us_[i + 1];
  }
  return edges_us_.back();
}

}  // namespace stillframe::report
