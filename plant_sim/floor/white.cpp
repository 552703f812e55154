#include "plant_sim/floor/white.hpp"

#include <cmath>

#include "plant_sim/counter_noise.hpp"

namespace stillframe::floor {

Eigen::MatrixXd gaussian_noise(std::uint64_t seed, const std::vector<Eigen::Index>& channels,
                               Eigen::Index samples) {
  Eigen::MatrixXd noise(static_cast<Eigen::Index>(channels.size()), samples);
  for (Eigen::Index i = 0; i < noise.rows(); ++i) {
    const CounterNoise draw(seed,
                            {static_cast<std::uint64_t>(channels[static_cast<std::size_t>(i)])});
    for (Eigen::Index k = 0; k < samples; k += 2) {
      const auto [radius, angle] = draw.polar(k / 2);
      noise(i, k) = radius * std::cos(angle);
      if (k + 1 < samples) noise(i, k + 1) = radius * std::sin(angle);
    }
  }
  return noise;
}

}  // namespace stillframe::floor
