#include "core/linear/sampled_loop.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <stdexcept>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>

#include "core/linear/balance.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

SampledPlant sample_and_hold(const LoopPlant& plant, double sample_time) {
  if (!(sample_time > 0)) {
    throw std::invalid_argument("sample_and_hold: sample_time must be positive, got " +
                                std::to_string(sample_time));
  }
  const Index n = plant.A.rows(), p = plant.B_w.cols(), m = plant.B_u.cols();
  const Index n_y = plant.C_y.rows(), total = n + p + m + n_y;
  MatrixXd augmented = MatrixXd::Zero(total, total);
  augmented.topLeftCorner(n, n + p + m) << plant.A, plant.B_w, plant.B_u;
  augmented.bottomLeftCorner(n_y, n + p + m) << plant.C_y, plant.D_yw, plant.D_yu;
  const MatrixXd exponential = (augmented * sample_time).exp();
  const MatrixXd mean = exponential.bottomLeftCorner(n_y, n + p + m) / sample_time;
  return {.Phi = exponential.topLeftCorner(n, n),
          .Gamma_w = exponential.block(0, n, n, p),
          .Gamma_u = exponential.block(0, n + p, n, m),
          .C_y = mean.leftCols(n),
          .D_yw = mean.middleCols(n, p),
          .D_yu = mean.rightCols(m),
          .C_sigma = plant.C_sigma,
          .n_exogenous = plant.n_exogenous,
          .sample_time = sample_time};
}

namespace {

void check_shapes(const SampledPlant& plant, const DiscreteLaw& law, int delay_samples) {
  const Index m = plant.Gamma_u.cols(), n = law.A.rows();
  if (delay_samples < 0) throw std::invalid_argument("close_loop: negative delay");
  const bool fits = law.A.cols() == n && law.B.rows() == n && law.B.cols() == m &&
                    law.C.rows() == m && law.C.cols() == n && law.D.rows() == m &&
                    law.D.cols() == m && plant.C_sigma.rows() == m;
  if (!fits) {
    throw std::invalid_argument("close_loop: the law does not fit a plant of " + std::to_string(m) +
                                " legs");
  }
}

/// Writes xi in the order [exogenous plant states | plant states | law | applied | pending
/// commands], so that the feedback part is one trailing block.
Eigen::PermutationMatrix<Eigen::Dynamic> exogenous_first(Index n, Index n_exogenous, Index total) {
  Eigen::VectorXi target(total);
  for (Index i = 0; i < total; ++i) {
    const Index to = i < n - n_exogenous ? i + n_exogenous : i < n ? i - (n - n_exogenous) : i;
    target(i) = static_cast<int>(to);
  }
  return Eigen::PermutationMatrix<Eigen::Dynamic>(target);
}

/// The same system in balanced states, the exogenous ones first. Unbalanced, a frame that moves
/// micrometres under forces of newtons has a spectral radius wrong in the second digit.
SampledLoop arranged(SampledLoop loop, Index n_plant) {
  const auto P = exogenous_first(n_plant, loop.n_exogenous, loop.A.rows());
  const Eigen::VectorXd S = balancing_scales(P * loop.A * P.transpose());
  loop.A = S.cwiseInverse().asDiagonal() * (P * loop.A * P.transpose()) * S.asDiagonal();
  loop.B = S.cwiseInverse().asDiagonal() * (P * loop.B);
  loop.C = loop.C * P.transpose() * S.asDiagonal();
  return loop;
}

}  // namespace

SampledLoop close_loop(const SampledPlant& plant, const DiscreteLaw& law, int delay_samples) {
  check_shapes(plant, law, delay_samples);
  const Index n = plant.Phi.rows(), m = plant.Gamma_u.cols(), p = plant.Gamma_w.cols();
  const Index n_law = law.A.rows();
  const Index i_law = n, i_applied = n + n_law, i_pending = i_applied + m;
  const Index total = i_pending + m * delay_samples;

  // e = C_e xi is the law's input, u = C_u xi its command, f = C_f xi the force held over the
  // coming interval.
  MatrixXd C_e = MatrixXd::Zero(m, total);
  C_e.leftCols(n) = plant.C_sigma;
  if (!law.subtract_applied) C_e.middleCols(i_applied, m).setIdentity();
  MatrixXd C_u = law.D * C_e;
  C_u.middleCols(i_law, n_law) += law.C;
  MatrixXd C_f = C_u;
  if (delay_samples > 0) {
    C_f.setZero();
    C_f.middleCols(i_pending, m).setIdentity();
  }

  SampledLoop loop;
  loop.n_exogenous = plant.n_exogenous;
  loop.sample_time = plant.sample_time;
  loop.A = MatrixXd::Zero(total, total);
  loop.A.topRows(n) = plant.Gamma_u * C_f;
  loop.A.topLeftCorner(n, n) += plant.Phi;
  loop.A.middleRows(i_law, n_law) = law.B * C_e;
  loop.A.block(i_law, i_law, n_law, n_law) += law.A;
  loop.A.middleRows(i_applied, m) = C_f;
  for (int d = 0; d < delay_samples; ++d) {
    const Index row = i_pending + m * d;
    if (d + 1 < delay_samples) {
      loop.A.block(row, row + m, m, m).setIdentity();
    } else {
      loop.A.middleRows(row, m) = C_u;
    }
  }
  loop.B = MatrixXd::Zero(total, p);
  loop.B.topRows(n) = plant.Gamma_w;
  loop.C = plant.D_yu * C_f;
  loop.C.leftCols(n) += plant.C_y;
  loop.D = plant.D_yw;
  return arranged(std::move(loop), n);
}

SampledLoop open_loop(const SampledPlant& plant) {
  SampledLoop loop{.A = plant.Phi,
                   .B = plant.Gamma_w,
                   .C = plant.C_y,
                   .D = plant.D_yw,
                   .n_exogenous = plant.n_exogenous,
                   .sample_time = plant.sample_time};
  return arranged(std::move(loop), plant.Phi.rows());
}

double spectral_radius(const SampledLoop& loop) {
  const Index n = loop.A.rows() - loop.n_exogenous;
  return loop.A.bottomRightCorner(n, n).eigenvalues().cwiseAbs().maxCoeff();
}

MatrixXcd transfer(const SampledLoop& loop, double omega) {
  const std::complex<double> z = std::polar(1.0, omega * loop.sample_time);
  MatrixXcd resolvent = -loop.A.cast<std::complex<double>>();
  resolvent.diagonal().array() += z;
  return loop.C * resolvent.partialPivLu().solve(loop.B.cast<std::complex<double>>()) + loop.D;
}

}  // namespace stillframe
