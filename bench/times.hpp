#pragma once

#include <sched.h>
#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace stillframe {

/// Times in ns, kept whole: no bins, no interpolation.
class Times {
 public:
  explicit Times(std::size_t capacity) { values_.reserve(capacity); }

  void add(std::int64_t ns) noexcept {
    if (values_.size() < values_.capacity()) values_.push_back(ns);
  }
  std::size_t count() const { return values_.size(); }
  const std::vector<std::int64_t>& values() const { return values_; }
  void append(const Times& other) {
    values_.insert(values_.end(), other.values_.begin(), other.values_.end());
  }

  /// The least time that a part of all (0 to 1) does not exceed, ns.
  std::int64_t quantile(double part) const {
    if (values_.empty()) return 0;
    std::vector<std::int64_t> sorted = values_;
    const auto n = static_cast<double>(sorted.size());
    const auto i = std::max<std::ptrdiff_t>(0, std::llround(std::ceil(part * n)) - 1);
    std::nth_element(sorted.begin(), sorted.begin() + i, sorted.end());
    return sorted[static_cast<std::size_t>(i)];
  }

  /// One row of a table of p50, p99, p99.9 and worst, in us.
  void print_row(const std::string& name) const {
    std::printf("%-44s %9zu %9.2f %9.2f %9.2f %10.2f\n", name.c_str(), count(),
                1e-3 * quantile(0.5), 1e-3 * quantile(0.99), 1e-3 * quantile(0.999),
                1e-3 * quantile(1));
  }
  static void print_head(const std::string& name) {
    std::printf("%-44s %9s %9s %9s %9s %10s\n", name.c_str(), "n", "p50 us", "p99 us", "p99.9 us",
                "worst us");
  }

  /// Writes "time count" lines, ns.
  void write(const std::string& file) const {
    std::vector<std::int64_t> sorted = values_;
    std::sort(sorted.begin(), sorted.end());
    std::ofstream out(file);
    for (std::size_t i = 0; i < sorted.size();) {
      const auto j = std::upper_bound(sorted.begin() + static_cast<std::ptrdiff_t>(i), sorted.end(),
                                      sorted[i]) -
                     sorted.begin();
      out << sorted[i] << ' ' << static_cast<std::size_t>(j) - i << '\n';
      i = static_cast<std::size_t>(j);
    }
    if (!out) throw std::runtime_error("cannot write " + file);
  }

 private:
  std::vector<std::int64_t> values_;
};

/// SCHED_FIFO for this thread and those it starts, 0 leaves it as it is. Errors:
/// std::runtime_error.
inline void use_fifo(int priority) {
  if (priority == 0) return;
  const sched_param parameters{.sched_priority = priority};
  if (sched_setscheduler(0, SCHED_FIFO, &parameters) != 0) {
    throw std::runtime_error("SCHED_FIFO is not allowed here");
  }
}

}  // namespace stillframe
