#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <numeric>
#include <vector>

namespace stillframe::floor {

/// 0 to n - 1.
inline std::vector<Eigen::Index> first_channels(Eigen::Index n) {
  std::vector<Eigen::Index> channels(static_cast<std::size_t>(n));
  std::iota(channels.begin(), channels.end(), Eigen::Index{0});
  return channels;
}

/// Independent Gaussian noise on each channel, of variance 1, by CounterNoise: a channel (by its
/// number) has the same whichever others there are. Returns channels x samples.
Eigen::MatrixXd gaussian_noise(std::uint64_t seed, const std::vector<Eigen::Index>& channels,
                               Eigen::Index samples);

}  // namespace stillframe::floor
