#include "core/mechanics/sparse/reduction_bound.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <limits>

#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/singular_values.hpp"

namespace stillframe {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

/// Columns C of coefficients in the norm of a Gram matrix.
struct Measured {
  double norm = 0, sizes = 0;  ///< the largest there is, and what rounding of its sum is of
};

Measured measured(const MatrixXcd& C, const MatrixXd& gram, double rounding) {
  const MatrixXcd square = C.adjoint() * (gram * C);
  const double largest = Eigen::SelfAdjointEigenSolver<MatrixXcd>(square, Eigen::EigenvaluesOnly)
                             .eigenvalues()(square.rows() - 1);
  const Eigen::VectorXd lengths = gram.diagonal().cwiseMax(0).cwiseSqrt();
  const double sizes = (C.cwiseAbs().transpose() * lengths).norm();
  const double hidden = rounding * sizes * sizes;
  return {std::sqrt(std::max(largest, 0.0) + hidden), sizes};
}

/// Residual forces of the inputs and the outputs at s: coefficients of the columns of W.
struct Residuals {
  MatrixXcd in, out;
  double rounding = 0;  ///< of the response on modes and corrections
};

Residuals residuals(const ReductionBound& bound, Complex s, Index n_in, Index n_out) {
  const LinearModel& V = bound.projected;
  const Index n = V.M.rows(), n_u = V.B.cols(), n_y = V.Y_p.rows();
  const Complex square = s * s;
  // Where the columns of W stand.
  const Index M_w = n_u, D_w = 2 * n_u, K_w = 3 * n_u, M_V = 4 * n_u, Y = M_V + 3 * n;
  Residuals left{MatrixXcd::Zero(bound.gram.rows(), n_u), MatrixXcd::Zero(bound.gram.rows(), n_y)};
  MatrixXcd f(n, n_u), y(n, n_y);
  for (Index j = 0; j < n_u; ++j) {
    const Quantity quantity = V.inputs[static_cast<size_t>(j)].quantity;
    if (!is_motion(quantity)) {
      left.in(j, j) = 1;
      f.col(j) = V.B.col(j).cast<Complex>();
      continue;
    }
    const Complex position = position_of(quantity, s);
    left.in(M_w + j, j) = -square * position;
    left.in(D_w + j, j) = -s * position;
    left.in(K_w + j, j) = -position;
    f.col(j) = -position * (square * V.M_r.col(j) + s * V.D_r.col(j) + V.K_r.col(j));
  }
  for (Index i = 0; i < n_y; ++i) {
    left.out(Y + i, i) = 1;
    left.out(Y + n_y + i, i) = s;
    left.out(Y + 2 * n_y + i, i) = square;
  }
  const Eigen::PartialPivLU<MatrixXcd> solver(MatrixXcd(square * V.M + s * V.D + V.K + V.G));
  const auto take = [&](const MatrixXcd& q, MatrixXcd& of) {
    of.middleRows(M_V, 3 * n) << -(square - bound.shift) * q, -s * q, -q;
  };
  const MatrixXcd q = solver.solve(f);
  y = (V.Y_p + s * V.Y_v + square * V.Y_a).transpose();
  const MatrixXcd q_l = solver.solve(y);
  take(q, left.in);
  take(q_l, left.out);
  const Index n_m = bound.n_modes;
  left.rounding =
      10 * eps * static_cast<double>(n) *
          ((y.cwiseAbs().transpose() * q.cwiseAbs()).norm() + transfer_function(V, s).norm()) +
      (q_l.topRows(n_m).cwiseAbs().transpose() * bound.known_to.asDiagonal() *
       q.topRows(n_m).cwiseAbs())
          .norm();
  left.in.conservativeResize(Eigen::NoChange, n_in);
  left.out.conservativeResize(Eigen::NoChange, n_out);
  return left;
}

/// What dampers carry from what is left out there and back through the kept modes.
double carried(const ReductionBound& bound, double omega) {
  const LinearModel& V = bound.projected;
  const Index n_m = bound.n_modes;
  if (n_m == 0 || V.D.isZero(0)) return 0;
  const Index D_V = 4 * V.B.cols() + V.M.rows();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> S(bound.gram.block(D_V, D_V, n_m, n_m));
  const MatrixXd root = S.eigenvectors() * S.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() *
                        S.eigenvectors().transpose();
  const MatrixXcd H = (-omega * omega * V.M + V.K + V.G).topLeftCorner(n_m, n_m) +
                      Complex(0, omega) * V.D.topLeftCorner(n_m, n_m);
  return omega * omega * singular_values(root * H.partialPivLu().solve(root.cast<Complex>()))(0);
}

}  // namespace

double ReductionBound::operator()(double omega, const LinearModel& reduced, Index n_in,
                                  Index n_out) const {
  constexpr double none = infinity;
  if (!(omega < first_left_out)) return none;
  double undamped = 1;
  if (std::isfinite(first_left_out)) {
    const double left_out = first_left_out * first_left_out;
    undamped = (left_out - omega * omega) / (left_out + shift);
  }
  const double delta = carried(*this, omega), alpha = undamped - delta;
  if (!(alpha > 0)) return none;
  const Complex s(0, omega);
  const Residuals left = residuals(*this, s, n_in, n_out);
  const Measured in = measured(left.in, gram, rounding), out = measured(left.out, gram, rounding);
  const double at_rest = singular_values(MatrixXcd(left.out.transpose() * (gram * left.in)))(0) +
                         rounding * in.sizes * out.sizes;
  // A norm is the root of what has cancelled, and has half of the digits that at_rest has.
  const double both = std::max(in.norm * out.norm, at_rest);
  const double parted =
      0.5 * (1 + 1 / undamped) * at_rest +
      (0.5 * (1 / undamped - 1) + (omega * damping + delta) / (undamped * alpha)) * both;
  const MatrixXcd missing = transfer_function(reduced, s) - transfer_function(projected, s);
  const double missed = singular_values(MatrixXcd(missing.topLeftCorner(n_out, n_in)))(0);
  const double bound = std::min(both / alpha, parted) + missed + left.rounding;
  return std::isfinite(bound) ? bound : none;
}

}  // namespace stillframe
