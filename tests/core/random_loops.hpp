#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <random>

#include "core/control/loop_settings.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe::test {

/// Numbers that are the same with every compiler and library.
class Draws {
 public:
  explicit Draws(unsigned seed) : engine_(seed) {}
  double between(double low, double high) { return low + (high - low) * engine_() / 4294967296.0; }
  double decades(double low, double high) { return std::pow(10, between(low, high)); }
  bool coin() { return engine_() % 2 == 0; }

 private:
  std::mt19937 engine_;
};

/// A loop of 1 to 3 legs on a plant of up to four modes more than legs, 3 to 400 Hz and damped by
/// 1e-5 to 5 %, with a rate of 200 Hz to 20 kHz, delays with fractions, lead, roll-off and
/// instruments or none of them; the gains put the plant without its further modes on a target. It
/// need not be stable.
inline LoopSettings random_loop(unsigned seed) {
  using Eigen::Index;
  using Eigen::MatrixXd;
  using Eigen::VectorXd;
  Draws draw(seed);
  const auto m = static_cast<Index>(draw.between(1, 4)),
             n = m + static_cast<Index>(draw.between(0, 5));
  // Modal coordinates of unit mass, q'' + D q' + K q = -E^T u, sigma = S E q + u with the stiffness
  // S of the legs: K = E^T S E + a stiffness of the other elements.
  const MatrixXd E = MatrixXd::NullaryExpr(m, n, [&] { return draw.between(-1, 1); });
  const VectorXd S =
      VectorXd::NullaryExpr(m, [&] { return std::pow(two_pi * draw.decades(0.5, 2), 2); });
  const MatrixXd R = Eigen::HouseholderQR<MatrixXd>(MatrixXd::NullaryExpr(n, n, [&] {
                       return draw.between(-1, 1);
                     })).householderQ();
  VectorXd other =
      VectorXd::NullaryExpr(n, [&] { return std::pow(two_pi * draw.decades(1, 2.6), 2); });
  if (n == m) other.setZero();
  const MatrixXd K = E.transpose() * S.asDiagonal() * E + R * other.asDiagonal() * R.transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(K);
  const MatrixXd D = 2 * draw.decades(-5, -1.3) * modes.operatorSqrt();
  LoopSettings out;
  out.plant.A = MatrixXd::Zero(2 * n, 2 * n);
  out.plant.A.topRightCorner(n, n).setIdentity();
  out.plant.A.bottomRows(n) << -K, -D;
  out.plant.B_w = MatrixXd::Zero(2 * n, 0);
  out.plant.B_u = MatrixXd::Zero(2 * n, m);
  out.plant.B_u.bottomRows(n) = -E.transpose();
  out.plant.C_y = MatrixXd::Zero(0, 2 * n);
  out.plant.D_yw = MatrixXd::Zero(0, 0);
  out.plant.D_yu = MatrixXd::Zero(0, m);
  out.plant.C_sigma = MatrixXd::Zero(m, 2 * n);
  out.plant.C_sigma.leftCols(n) = S.asDiagonal() * E;
  // As design_gains on static shapes: X = K_l M_l^-1 / omega_d^2 of the legs' elongations.
  const MatrixXd E_K = K.llt().solve(E.transpose());  // K^-1 E^T
  const MatrixXd K_l = (E * E_K).inverse(), Psi = E_K * K_l;
  const MatrixXd X_1 = K_l * (Psi.transpose() * Psi).inverse();
  const double target = two_pi * draw.decades(0, 1.3), zeta = draw.between(0.3, 1.2);
  out.feedback.K_P = X_1 / (target * target) - MatrixXd::Identity(m, m);
  out.feedback.K_I = 2 * zeta / target * X_1;
  out.feedback.leak = target * draw.decades(-2.5, -0.7);
  if (draw.coin()) out.feedback.high_pass = out.feedback.leak * draw.between(0.3, 1);
  Sampling& sampling = out.sampling;
  sampling.sample_time = 1 / draw.decades(2.3, 4.3);
  sampling.delay_samples = draw.coin() ? std::floor(draw.between(0, 3)) : draw.between(0, 2.5);
  Instruments& has = sampling.instruments;
  if (draw.coin()) has.actuator_lag_hz = draw.between(0.05, 0.4) / sampling.sample_time;
  if (draw.coin()) has.report = Instruments::Report::measured;
  if (draw.between(0, 1) < 0.2)
    has.sensor_filter_hz = draw.between(0.1, 0.4) / sampling.sample_time;
  if (draw.between(0, 1) < 0.1) has.report_age_samples = 1;
  if (draw.coin()) {
    out.feedback.roll_off = draw.between(0.02, 0.3) * two_pi / sampling.sample_time;
  }
  if (draw.coin()) out.law.lead_samples = draw.between(0, 1.5) * lateness(sampling);
  return out;
}

}  // namespace stillframe::test
