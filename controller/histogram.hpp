#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace stillframe::controller {

/// How often a time came, in bins of a 64th of an octave from 1 ns to 17 s, so that a quantile is
/// known to 1.1 %. add is hot: noexcept, no allocation.
class Histogram {
 public:
  static constexpr int bins_per_octave = 64, n_octaves = 34;

  /// Counts a time (ns); below 1 ns counts as 1 ns, above 17 s as 17 s.
  void add(std::int64_t ns) noexcept;

  /// Takes over the counts of another one.
  void add(const Histogram& other) noexcept;

  std::int64_t count() const noexcept { return count_; }
  std::int64_t worst_ns() const noexcept { return worst_; }

  /// The time (ns) that a part of all (0 to 1) does not exceed: the upper edge of its bin, at most
  /// the worst; 0 if nothing was counted.
  double quantile(double part) const noexcept;

  /// {"n_times", "p50_ns", "p99_ns", "p999_ns", "worst_ns", "edges_ns": [...], "counts": [...]} of
  /// the bins that are not empty. Set-up.
  std::string to_json() const;

 private:
  std::array<std::int64_t, static_cast<std::size_t>(bins_per_octave* n_octaves)> counts_{};
  std::int64_t count_ = 0, worst_ = 0;
};

}  // namespace stillframe::controller
