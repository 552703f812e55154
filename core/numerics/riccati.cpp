#include "core/numerics/riccati.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/balance.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/stein.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Below this part of the largest eigenvalue R, with a diagonal of ones, is singular but for
/// rounding.
constexpr double singular = 1e-13;

void check(const RiccatiProblem& p) {
  const Index n = p.A.rows(), m = p.B.cols();
  const bool fits = p.A.cols() == n && p.B.rows() == n && p.Q.rows() == n && p.Q.cols() == n &&
                    p.R.rows() == m && p.R.cols() == m &&
                    (p.S.size() == 0 || (p.S.rows() == n && p.S.cols() == m));
  if (!fits) throw std::invalid_argument("solve_riccati: shapes that do not match");
  if (!p.A.allFinite() || !p.B.allFinite() || !p.Q.allFinite() || !p.R.allFinite() ||
      !p.S.allFinite()) {
    throw std::invalid_argument("solve_riccati: entries that are not finite");
  }
}

/// One over the square roots of the diagonal of R, which becomes ones.
VectorXd input_scales(const MatrixXd& R) {
  const VectorXd diagonal = R.diagonal();
  for (Index i = 0; i < diagonal.size(); ++i) {
    if (!(diagonal(i) > 0)) {
      throw Refusal("Riccati equation: R(" + std::to_string(i + 1) + ", " + std::to_string(i + 1) +
                    ") is " + formatted("%.3g", diagonal(i)) +
                    "; every input has to have a cost, so R must be positive definite");
    }
  }
  VectorXd scales = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> values(
      scales.asDiagonal() * R * scales.asDiagonal(), Eigen::EigenvaluesOnly);
  const double least = values.eigenvalues().minCoeff(), most = values.eigenvalues().maxCoeff();
  if (!(least > singular * most)) {
    throw Refusal("Riccati equation: R, scaled to a diagonal of ones, has an eigenvalue of " +
                  formatted("%.3g", least) + " beside " + formatted("%.3g", most) +
                  "; it must be positive definite");
  }
  return scales;
}

/// The scales x = d z, powers of two, for which A, G = B R^-1 B^T and Q are of like size: those
/// that balance [A, G; Q, A^T] as x and its costate must be scaled, by d and 1/d.
VectorXd state_scales(const MatrixXd& A, const MatrixXd& G, const MatrixXd& Q) {
  const Index n = A.rows();
  MatrixXd pencil(2 * n, 2 * n);
  pencil << A, G, Q, A.transpose();
  const VectorXd both = balancing_scales(pencil.cwiseAbs());
  VectorXd scales(n);
  for (Index i = 0; i < n; ++i) {
    scales(i) = std::exp2(std::round(std::log2(both(i) / both(n + i)) / 2));
  }
  return scales;
}

[[noreturn]] void refuse(const std::string& found) {
  throw Refusal("Riccati equation: no solution that stabilises (" + found +
                "); a mode on or outside the unit circle is not controllable, or the cost does not "
                "see one that is on it");
}

/// X of X = A^T X (I + G X)^-1 A + H.
MatrixXd doubled(MatrixXd A, MatrixXd G, MatrixXd H) {
  constexpr int most = 60;
  const Index n = A.rows();
  const MatrixXd I = MatrixXd::Identity(n, n);
  double before = 0;
  for (int k = 0; k < most; ++k) {
    const Eigen::PartialPivLU<MatrixXd> W(I + G * H);
    const MatrixXd V_A = W.solve(A), V_G = W.solve(G);
    const MatrixXd more = A.transpose() * H * V_A;
    G += A * V_G * A.transpose();
    H += more;
    A = (A * V_A).eval();
    G = ((G + G.transpose()) / 2).eval();
    H = ((H + H.transpose()) / 2).eval();
    if (!H.allFinite() || !G.allFinite()) refuse("the doubling overflows");
    const double step = more.norm();
    if (step <= 1e-15 * H.norm()) return H;
    // Beside rounding nothing gets smaller any more; Newton's steps take it from here.
    if (k > 5 && step <= 1e-12 * H.norm() && step >= before) return H;
    before = step;
  }
  refuse("the doubling does not end");
}

/// The problem in scaled inputs and states.
class Scaled {
 public:
  explicit Scaled(const RiccatiProblem& p) : of_inputs_(input_scales(p.R)) {
    const Index n = p.A.rows(), m = p.B.cols();
    R = of_inputs_.asDiagonal() * p.R * of_inputs_.asDiagonal();
    B = p.B * of_inputs_.asDiagonal();
    S = MatrixXd::Zero(n, m);
    if (p.S.size() > 0) S = p.S * of_inputs_.asDiagonal();
    A = p.A;
    Q = (p.Q + p.Q.transpose()) / 2;
    const Eigen::LLT<MatrixXd> llt(R);
    of_states_ = state_scales(A - B * llt.solve(S.transpose()), B * llt.solve(B.transpose()),
                              Q - S * llt.solve(S.transpose()));
    const auto d = of_states_.asDiagonal();
    const auto d_inverse = of_states_.cwiseInverse().asDiagonal();
    A = d_inverse * A * d;
    B = d_inverse * B;
    S = d * S;
    Q = d * Q * d;
  }

  MatrixXd first() const {
    const Eigen::LLT<MatrixXd> llt(R);
    const MatrixXd R_S = llt.solve(S.transpose());
    return doubled(A - B * R_S, B * llt.solve(B.transpose()), Q - S * R_S);
  }
  MatrixXd gain(const MatrixXd& X) const {
    const MatrixXd XB = X * B;
    return (R + B.transpose() * XB).ldlt().solve(XB.transpose() * A + S.transpose());
  }
  double residual(const MatrixXd& X) const {
    const MatrixXd AXA = A.transpose() * X * A, AXB = A.transpose() * X * B + S;
    const MatrixXd last = AXB * (R + B.transpose() * X * B).ldlt().solve(AXB.transpose());
    const double size = X.norm() + AXA.norm() + last.norm() + Q.norm();
    return size > 0 ? (AXA - last + Q - X).norm() / size : 0;
  }
  /// Newton's step: the cost of the law that X stands for.
  MatrixXd next(const MatrixXd& X) const {
    const MatrixXd K = gain(X), SK = S * K;
    const MatrixXd cost = Q - SK - SK.transpose() + K.transpose() * R * K;
    const MatrixXd Y = solve_stein(A - B * K, (cost + cost.transpose()) / 2);
    return (Y + Y.transpose()) / 2;
  }
  double radius(const MatrixXd& K) const { return spectral_radius(MatrixXd(A - B * K)); }

  MatrixXd unscaled_X(const MatrixXd& X) const {
    const auto inverse = of_states_.cwiseInverse().asDiagonal();
    return inverse * X * inverse;
  }
  MatrixXd unscaled_K(const MatrixXd& K) const {
    return of_inputs_.asDiagonal() * K * of_states_.cwiseInverse().asDiagonal();
  }

 private:
  MatrixXd A, B, Q, R, S;
  VectorXd of_inputs_, of_states_;
};

}  // namespace

RiccatiSolution solve_riccati(const RiccatiProblem& problem) {
  check(problem);
  const Scaled scaled(problem);
  MatrixXd X = scaled.first();
  RiccatiSolution found;
  found.residual = scaled.residual(X);
  for (int i = 0; i < 5; ++i) {
    const MatrixXd next = scaled.next(X);
    const double residual = scaled.residual(next);
    if (!(residual < found.residual)) break;
    X = next;
    found.residual = residual;
  }
  const MatrixXd K = scaled.gain(X);
  found.radius = scaled.radius(K);
  if (!(found.radius < 1)) refuse("spectral radius " + formatted("%.3g", found.radius));
  found.X = scaled.unscaled_X(X);
  found.K = scaled.unscaled_K(K);
  return found;
}

}  // namespace stillframe
