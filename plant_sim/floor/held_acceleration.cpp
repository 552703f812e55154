#include "plant_sim/floor/held_acceleration.hpp"

#include <cmath>
#include <numbers>

namespace stillframe::floor {

double held_acceleration_gain(double frequency_hz, double rate) noexcept {
  // 2 - 2 cos(2 p) = 4 sin(p)^2, which loses no digits where p is small.
  const double twice = 2.0 * std::sin(std::numbers::pi * frequency_hz / rate) * rate;
  return twice * twice;
}

Eigen::VectorXd held_accelerations(const Eigen::VectorXd& position, double rate) {
  const Eigen::Index n = position.size();
  Eigen::VectorXd acceleration(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    acceleration(k) = held_acceleration(k > 0 ? position(k - 1) : 0.0, position(k),
                                        position(k + 1 < n ? k + 1 : k), rate);
  }
  return acceleration;
}

}  // namespace stillframe::floor
