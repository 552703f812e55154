#include "core/systems/sampled_loop.hpp"

#include <Eigen/LU>
#include <Eigen/SparseLU>

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

using Sparse = Eigen::SparseMatrix<Complex>;

MatrixXcd less(const MatrixXd& A, Complex z) {
  MatrixXcd resolvent = -A.cast<Complex>();
  resolvent.diagonal().array() += z;
  return resolvent;
}

/// (z I - E)^-1 B of states that are mostly each other's sample before.
MatrixXcd of_exogenous(const MatrixXd& E, const MatrixXcd& B, Complex z) {
  const Sparse resolvent = less(E, z).sparseView();
  Eigen::SparseLU<Sparse> lu;
  lu.compute(resolvent);
  if (lu.info() != Eigen::Success) return less(E, z).partialPivLu().solve(B);
  return lu.solve(B);
}

/// C (z I - A)^-1 B. A feed-forward has hundreds of exogenous states, which nothing in the loop
/// moves: A = [E 0; G L] is solved one after the other.
MatrixXcd resolved(const SampledLoop& loop, const MatrixXcd& B, Complex z) {
  constexpr Index many = 32;
  const Index e = loop.n_exogenous, n = loop.A.rows() - e;
  if (e < many) return loop.C * less(loop.A, z).partialPivLu().solve(B);
  MatrixXcd X(e + n, B.cols());
  X.topRows(e) = of_exogenous(loop.A.topLeftCorner(e, e), B.topRows(e), z);
  X.bottomRows(n) = less(loop.A.bottomRightCorner(n, n), z)
                        .partialPivLu()
                        .solve(B.bottomRows(n) + loop.A.bottomLeftCorner(n, e) * X.topRows(e));
  return loop.C * X;
}

}  // namespace

MatrixXcd transfer(const SampledLoop& loop, double omega) {
  const Complex z = std::polar(1.0, omega * loop.sample_time);
  return resolved(loop, loop.B.cast<Complex>(), z) + loop.D;
}

MatrixXcd noise_transfer(const SampledLoop& loop, double omega) {
  const Complex z = std::polar(1.0, omega * loop.sample_time);
  return resolved(loop, loop.B_v.cast<Complex>(), z) + loop.D_v;
}

}  // namespace stillframe
