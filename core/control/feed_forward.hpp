#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/systems/linear_system.hpp"

namespace stillframe {

/// Feed-forward of m legs from the accelerations of p floor channels, sampled:
///   h = ((1 - z^-1) / (1 - a z^-1))^2 w,   l_i = ((1 - a) / (1 - a z^-1))^i h,
///   u = sum_i Theta_i z^-i h + Theta_n l_1 + Theta_{n+1} l_2,   i = 0 .. n - 1.
/// The first sample of w is the one that stands in the measurement that is answered. What sensors
/// are constantly off by is taken out, so that its double integral commands nothing; the taps make
/// up for delay, hold and instruments, the leaky integrals are the floor's velocity and position
/// above the corner of a. Source: docs/decisions/0030-floor-feed-forward.md.
struct FeedForward {
  double memory = 0;             ///< a, 1
  Eigen::Index n_taps = 0;       ///< n, 2 or more; 0: there is no feed-forward
  Eigen::MatrixXd weights = {};  ///< m x p (n + 2), N per m/s^2: Theta_0 to Theta_{n+1}

  bool empty() const { return n_taps == 0; }
  Eigen::Index n_terms() const { return n_taps + 2; }
  Eigen::Index n_floor() const { return empty() ? 0 : weights.cols() / n_terms(); }
};

/// What the weights multiply, of w = 1 at z: n_taps + 2 values.
Eigen::VectorXcd feed_forward_terms(double memory, Eigen::Index n_taps, std::complex<double> z);

/// Theta(z), m x p, u over w. Of no empty filter.
Eigen::MatrixXcd response_of(const FeedForward& filter, std::complex<double> z);

/// The same filter as a sampled system with inputs w and outputs u, of p (n + 3) states. Empty for
/// an empty one. Errors: std::invalid_argument on sizes that do not match, or a memory that is not
/// below one.
LinearSystem feed_forward_system(const FeedForward& filter);

}  // namespace stillframe
