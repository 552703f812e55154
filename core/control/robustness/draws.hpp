#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace stillframe::robustness {

/// Number `counter` (from 0) of the generator SplitMix64 started with `seed`, without those before
/// it. Source: Steele, Lea and Flood, OOPSLA 2014, 453-472; constants of Vigna's version.
constexpr std::uint64_t splitmix64(std::uint64_t seed, std::uint64_t counter) {
  std::uint64_t z = seed + (counter + 1) * 0x9E3779B97F4A7C15ULL;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

/// Sample i of a seed: p numbers evenly distributed in (-1, 1), a function of (seed, i) alone, so
/// that any division of the samples among processes gives the same ones. Sample i takes the numbers
/// of a generator of its own, started with number i of the generator of the seed.
inline Eigen::VectorXd sample(std::uint64_t seed, std::uint64_t i, Eigen::Index p) {
  const std::uint64_t own = splitmix64(splitmix64(seed, 0), i);
  Eigen::VectorXd values(p);
  for (Eigen::Index j = 0; j < p; ++j) {
    // 53 random bits and a half: symmetric about 0, which is never met, nor are the ends.
    const auto bits = static_cast<double>(splitmix64(own, static_cast<std::uint64_t>(j)) >> 11);
    values(j) = (bits + 0.5) * 0x1p-52 - 1;
  }
  return values;
}

}  // namespace stillframe::robustness
