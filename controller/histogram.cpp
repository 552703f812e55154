#include "controller/histogram.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors/formatted.hpp"

namespace stillframe::controller {

namespace {

double upper_edge_ns(std::size_t bin) {
  return std::exp2((static_cast<double>(bin) + 1) / Histogram::bins_per_octave);
}

}  // namespace

void Histogram::add(std::int64_t ns) noexcept {
  const double octaves = std::log2(static_cast<double>(std::max<std::int64_t>(ns, 1)));
  const auto bin = static_cast<std::size_t>(octaves * bins_per_octave);
  ++counts_[std::min(bin, counts_.size() - 1)];
  ++count_;
  worst_ = std::max(worst_, ns);
}

void Histogram::add(const Histogram& other) noexcept {
  for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
  count_ += other.count_;
  worst_ = std::max(worst_, other.worst_);
}

double Histogram::quantile(double part) const noexcept {
  const auto wanted =
      std::max<std::int64_t>(1, std::llround(std::ceil(part * static_cast<double>(count_))));
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    sum += counts_[i];
    if (sum >= wanted) return std::min(upper_edge_ns(i), static_cast<double>(worst_));
  }
  return static_cast<double>(worst_);
}

std::string Histogram::to_json() const {
  const std::string text = formatted(
      "{\"n_times\": %lld, \"p50_ns\": %.0f, \"p99_ns\": %.0f, \"p999_ns\": %.0f, "
      "\"worst_ns\": %lld, ",
      static_cast<long long>(count_), quantile(0.5), quantile(0.99), quantile(0.999),
      static_cast<long long>(worst_));
  std::string edges, counts;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    if (counts_[i] == 0) continue;
    edges += formatted("%s%.6g", edges.empty() ? "" : ", ", upper_edge_ns(i));
    counts += (counts.empty() ? "" : ", ") + std::to_string(counts_[i]);
  }
  return text + ("\"edges_ns\": [" + edges + "], \"counts\": [" + counts + "]}");
}

}  // namespace stillframe::controller
