#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <string_view>

#include "core/numerics/two_pi.hpp"

namespace stillframe {

/// Gaussian numbers of mean 0 and variance 1 by their place: a seed, what they are for, and a
/// sample give the same number whatever was drawn before, with every standard library. splitmix64
/// words, jumped to, made Gaussian by the Box-Muller formula. Source: G. L. Steele, D. Lea, C. H.
/// Flood, OOPSLA 2014; G. E. P. Box, M. E. Muller, Ann. Math. Stat. 29 (1958) 610-611. Hot:
/// noexcept, no allocation.
class CounterNoise {
 public:
  /// place: of the stream, as its use and its channel.
  CounterNoise(std::uint64_t seed, std::initializer_list<std::uint64_t> place) noexcept
      : key_(mix(seed + stride)) {
    for (const std::uint64_t number : place) key_ = mix(key_ + number + 1);
  }

  double operator()(std::int64_t k) const noexcept {
    const auto [radius, angle] = polar(k);
    return radius * std::cos(angle);
  }

  /// Two independent ones, in polar coordinates.
  struct Pair {
    double radius, angle;
  };
  Pair polar(std::int64_t k) const noexcept {
    const std::uint64_t at = key_ + 2 * static_cast<std::uint64_t>(k) * stride;
    return {std::sqrt(-2 * std::log(uniform(mix(at + stride)))),
            two_pi * uniform(mix(at + 2 * stride))};
  }

  /// The seed of a source of noise by its name, so that sources with the same number under `seed`
  /// are independent of each other.
  static std::uint64_t seed_of(std::uint64_t seed, std::string_view source) noexcept {
    std::uint64_t word = mix(seed + stride);
    for (const char letter : source) word = mix(word + static_cast<unsigned char>(letter) + stride);
    return word;
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
