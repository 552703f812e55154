#pragma once

#include <Eigen/Core>
#include <cmath>
#include <random>

#include "tests/controller/toy_plant.hpp"

namespace stillframe::controller {

/// Accelerations of a floor: noise between 1 and 10 Hz, which a floor has most of and which comes
/// back to where it was. Its size below 10 Hz does not depend on the rate.
class MadeUpFloor {
 public:
  MadeUpFloor(double rate_hz, std::uint64_t seed)
      : low_(1 - std::exp(-two_pi * 10 / rate_hz)),
        high_(1 - std::exp(-two_pi / rate_hz)),
        scale_(std::sqrt(rate_hz / 1000)),
        random_(seed) {}
  /// The next sample (w: p, m/s^2) of a floor of that size (m/s^2).
  void operator()(double size, Eigen::VectorXd& w) {
    if (x_.cols() != w.size()) x_ = Eigen::Matrix3Xd::Zero(3, w.size());
    for (Eigen::Index j = 0; j < w.size(); ++j) {
      auto x = x_.col(j);
      x(0) += low_ * (size * scale_ * normal_(random_) - x(0));
      x(1) += high_ * (x(0) - x(1));
      x(2) += high_ * (x(0) - x(1) - x(2));
      w(j) = x(0) - x(1) - x(2);
    }
  }

 private:
  double low_, high_, scale_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  Eigen::Matrix3Xd x_;
};

}  // namespace stillframe::controller
