#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <numeric>
#include <string_view>
#include <vector>

namespace stillframe::floor {

/// The seed of a source of noise by its name, so that sources with the same number under `seed` are
/// independent of each other.
std::uint64_t seed_of(std::uint64_t seed, std::string_view source);

/// 0 to n - 1.
inline std::vector<Eigen::Index> first_channels(Eigen::Index n) {
  std::vector<Eigen::Index> channels(static_cast<std::size_t>(n));
  std::iota(channels.begin(), channels.end(), Eigen::Index{0});
  return channels;
}

/// Independent Gaussian noise on each channel, of variance 1: splitmix64 words made Gaussian by the
/// Box-Muller formula, so that a seed means the same numbers with every standard library, and a
/// channel (by its number) the same whichever others there are. Returns channels x samples. Source: G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014 (splitmix64);
/// G. E. P. Box, M. E. Muller, Ann. Math. Stat. 29 (1958) 610-611.
Eigen::MatrixXd gaussian_noise(std::uint64_t seed, const std::vector<Eigen::Index>& channels,
                               Eigen::Index samples);

}  // namespace stillframe::floor
