#include "core/systems/sampled_loop.hpp"

#include <Eigen/LU>

#include "core/numerics/eigenvalues.hpp"
#include "core/systems/balanced_states.hpp"

namespace stillframe {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

SampledLoop open_loop(const SampledPlant& plant) {
  SampledLoop loop{.A = plant.Phi,
                   .B = plant.Gamma_w,
                   .B_v = MatrixXd::Zero(plant.Phi.rows(), 0),
                   .C = plant.C_y,
                   .D = plant.D_yw,
                   .D_v = MatrixXd::Zero(plant.C_y.rows(), 0),
                   .n_exogenous = plant.n_exogenous,
                   .sample_time = plant.sample_time};
  const BalancedStates states(loop, plant.Phi.rows());
  return states.of(std::move(loop));
}

double spectral_radius(const SampledLoop& loop) {
  const Index n = loop.A.rows() - loop.n_exogenous;
  return spectral_radius(MatrixXd(loop.A.bottomRightCorner(n, n)));
}

namespace {

/// C (z I - A)^-1 B.
MatrixXcd resolved(const MatrixXd& C, const MatrixXd& A, const MatrixXcd& B, Complex z) {
  MatrixXcd resolvent = -A.cast<Complex>();
  resolvent.diagonal().array() += z;
  return C * resolvent.partialPivLu().solve(B);
}

}  // namespace

MatrixXcd transfer(const SampledLoop& loop, double omega) {
  const Complex z = std::polar(1.0, omega * loop.sample_time);
  return resolved(loop.C, loop.A, loop.B.cast<Complex>(), z) + loop.D;
}

MatrixXcd noise_transfer(const SampledLoop& loop, double omega) {
  const Complex z = std::polar(1.0, omega * loop.sample_time);
  return resolved(loop.C, loop.A, loop.B_v.cast<Complex>(), z) + loop.D_v;
}

}  // namespace stillframe
