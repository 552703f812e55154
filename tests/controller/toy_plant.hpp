#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "controller/gains.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe::controller::toy {

inline constexpr double damping_ratio = 0.7;

/// Undamped frequencies of the frame's four different modes, Hz.
inline const std::vector<double>& frequencies_hz() {
  static const std::vector<double> values{13.9, 20, 31.3, 49};
  return values;
}

/// Unit masses on one leg each, q'' + K q = -u, sigma = K q + u, z = (q, q'), with the exact gains
/// X = K M^-1 / w_d^2, K_I = 2 zeta w_d X; one floor moves all legs.
inline Gains gains(double design_hz, double rate_hz = 1000, int delay = 1, double leak_hz = 0.05) {
  const auto m = static_cast<Eigen::Index>(frequencies_hz().size());
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(m, m);
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(m, m);
  Gains out;
  for (Eigen::Index i = 0; i < m; ++i) {
    K(i, i) = std::pow(two_pi * frequencies_hz()[static_cast<size_t>(i)], 2);
    out.legs.push_back("leg_" + std::to_string(i + 1));
  }
  const double w_d = two_pi * design_hz;
  const Eigen::MatrixXd X = K / (w_d * w_d);
  out.scene_hash = "0123456789abcdef";
  out.sample_rate_hz = rate_hz;
  out.delay_samples = delay;
  out.leak_hz = leak_hz;
  out.K_P = X - I;
  out.K_I = 2 * damping_ratio * w_d * X;
  out.plant.A = Eigen::MatrixXd::Zero(2 * m, 2 * m);
  out.plant.A.topRightCorner(m, m) = I;
  out.plant.A.bottomLeftCorner(m, m) = -K;
  out.plant.B = Eigen::MatrixXd::Zero(2 * m, m);
  out.plant.B.bottomRows(m) = -I;
  out.plant.C = Eigen::MatrixXd::Zero(m, 2 * m);
  out.plant.C.leftCols(m) = K;
  out.plant.B_w = Eigen::MatrixXd::Zero(2 * m, 1);
  out.plant.B_w.bottomRows(m).setConstant(-1);
  out.force_limit_n = 200;
  return out;
}

/// The same frame with a damping of 1 % in its slowest mode, so that its resonance does not make
/// comparisons with it easy, and the lead that makes up for the delay.
inline Gains damped_gains(double design_hz = 5, double rate_hz = 1000) {
  Gains out = gains(design_hz, rate_hz);
  const auto m = out.n_legs();
  out.plant.A.bottomRightCorner(m, m).diagonal().setConstant(-2 * 0.01 * two_pi *
                                                             frequencies_hz().front());
  out.lead_samples = out.delay_samples + 0.5;
  return out;
}

/// The same frame with places as states in place of the elongations of its legs: the floor does by
/// its position x what its acceleration did, q'' = -K (q - x) - D (q' - x') - u,
/// sigma = K (q - x) + u.
inline Gains by_position(Gains out) {
  const auto m = out.n_legs();
  out.plant.B_w.setZero();
  out.plant.A_w = Eigen::MatrixXd::Zero(2 * m, 2);  // of velocity and position
  out.plant.A_w.bottomRows(m) << -out.plant.A.bottomRightCorner(m, m).rowwise().sum(),
      -out.plant.A.bottomLeftCorner(m, m).rowwise().sum();
  out.plant.C_w.resize(m, 2);
  out.plant.C_w << -out.plant.C.rightCols(m).rowwise().sum(),
      -out.plant.C.leftCols(m).rowwise().sum();
  return out;
}

/// One mode over a sample with u held, in closed form: q'' + K q = -u is a rotation about q = -u /
/// K.
inline void move(size_t mode, double& q, double& v, double u, double sample_time) {
  const double w = two_pi * frequencies_hz()[mode], angle = w * sample_time;
  const double rest = -u / (w * w), from_rest = q - rest;
  q = rest + from_rest * std::cos(angle) + v / w * std::sin(angle);
  v = v * std::cos(angle) - from_rest * w * std::sin(angle);
}

}  // namespace stillframe::controller::toy
