#include "plant_sim/floor/white.hpp"

#include <cmath>
#include <numbers>

namespace stillframe::floor {

namespace {

constexpr std::uint64_t stride = 0x9e3779b97f4a7c15u;  // 2^64 / golden ratio, odd

std::uint64_t mix(std::uint64_t word) {
  word = (word ^ (word >> 30)) * 0xbf58476d1ce4e5b9u;
  word = (word ^ (word >> 27)) * 0x94d049bb133111ebu;
  return word ^ (word >> 31);
}

/// Uniform in (0, 1]: the logarithm below must not see zero.
double uniform(std::uint64_t word) { return static_cast<double>((word >> 11) + 1) * 0x1p-53; }

}  // namespace

Eigen::MatrixXd gaussian_noise(std::uint64_t seed, Eigen::Index channels, Eigen::Index samples) {
  Eigen::MatrixXd noise(channels, samples);
  for (Eigen::Index i = 0; i < channels; ++i) {
    std::uint64_t state = mix(mix(seed + stride) + static_cast<std::uint64_t>(i) + 1);
    for (Eigen::Index k = 0; k < samples; k += 2) {
      const double radius = std::sqrt(-2.0 * std::log(uniform(mix(state += stride))));
      const double angle = 2.0 * std::numbers::pi * uniform(mix(state += stride));
      noise(i, k) = radius * std::cos(angle);
      if (k + 1 < samples) noise(i, k + 1) = radius * std::sin(angle);
    }
  }
  return noise;
}

}  // namespace stillframe::floor
