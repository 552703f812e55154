#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace stillframe {

/// Gaussian numbers of mean 0 and variance 1 by their place: a seed, a stream, a channel and a
/// sample k give the same number whatever was drawn before. splitmix64 words, jumped to, made
/// Gaussian by the Box-Muller formula. Source: G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014;
/// G. E. P. Box, M. E. Muller, Ann. Math. Stat. 29 (1958) 610-611. Hot: noexcept, no allocation.
class CounterNoise {
 public:
  CounterNoise(std::uint64_t seed, std::uint64_t stream, std::uint64_t channel) noexcept
      : key_(mix(mix(mix(seed + stride) + stream + 1) + channel + 1)) {}

  double operator()(std::int64_t k) const noexcept {
    const std::uint64_t at = key_ + 2 * static_cast<std::uint64_t>(k) * stride;
    const double radius = std::sqrt(-2 * std::log(uniform(mix(at + stride))));
    return radius * std::cos(2 * std::numbers::pi * uniform(mix(at + 2 * stride)));
  }

 private:
  static constexpr std::uint64_t stride = 0x9e3779b97f4a7c15u;  // 2^64 / golden ratio, odd

  static std::uint64_t mix(std::uint64_t word) noexcept {
    word = (word ^ (word >> 30)) * 0xbf58476d1ce4e5b9u;
    word = (word ^ (word >> 27)) * 0x94d049bb133111ebu;
    return word ^ (word >> 31);
  }

  /// In (0, 1]: the logarithm must not see zero.
  static double uniform(std::uint64_t word) noexcept {
    return static_cast<double>((word >> 11) + 1) * 0x1p-53;
  }

  std::uint64_t key_;
};

}  // namespace stillframe
