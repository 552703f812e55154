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

std::uint64_t seed_of(std::uint64_t seed, std::string_view source) {
  std::uint64_t word = mix(seed + stride);
  for (const char letter : source) word = mix(word + static_cast<unsigned char>(letter) + stride);
  return word;
}

Eigen::MatrixXd gaussian_noise(std::uint64_t seed, const std::vector<Eigen::Index>& channels,
                               Eigen::Index samples) {
  Eigen::MatrixXd noise(static_cast<Eigen::Index>(channels.size()), samples);
  for (Eigen::Index i = 0; i < noise.rows(); ++i) {
    const auto channel = static_cast<std::uint64_t>(channels[static_cast<std::size_t>(i)]);
    std::uint64_t state = mix(mix(seed + stride) + channel + 1);
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
