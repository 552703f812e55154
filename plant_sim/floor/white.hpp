#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace stillframe::floor {

/// Independent Gaussian noise on each channel, of variance 1: splitmix64 words made Gaussian by the
/// Box-Muller formula, so that a seed means the same numbers with every standard library.
/// Returns channels x samples. Source: G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014 (splitmix64);
/// G. E. P. Box, M. E. Muller, Ann. Math. Stat. 29 (1958) 610-611.
Eigen::MatrixXd gaussian_noise(std::uint64_t seed, Eigen::Index channels, Eigen::Index samples);

}  // namespace stillframe::floor
