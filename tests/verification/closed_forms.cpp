#include "tests/verification/closed_forms.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

namespace stillframe::verification {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double beam_root(int k, int sign) {
  // cos a = sign / cosh a keeps its size where cosh a is large.
  double a = (sign < 0 ? k - 0.5 : k + 0.5) * std::numbers::pi;
  for (int i = 0; i < 50; ++i) {
    const double f = std::cos(a) - sign / std::cosh(a);
    const double slope = -std::sin(a) + sign * std::tanh(a) / std::cosh(a);
    a -= f / slope;
  }
  return a;
}

double clamped_pinned_root() {
  double a = 4.5;
  for (int i = 0; i < 50; ++i) {
    a -= (std::sin(a) - a * std::cos(a)) / (a * std::sin(a));
  }
  return a;
}

namespace {

/// Gauss-Legendre points and weights on 0..1, from the eigenvalues of Jacobi's matrix.
struct Gauss {
  VectorXd x, w;
  explicit Gauss(Index n) {
    MatrixXd J = MatrixXd::Zero(n, n);
    for (Index i = 1; i < n; ++i) {
      const double k = static_cast<double>(i);
      J(i, i - 1) = J(i - 1, i) = k / std::sqrt(4 * k * k - 1);
    }
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(J);
    x = (solver.eigenvalues().array() + 1) / 2;
    w = solver.eigenvectors().row(0).array().square();
  }
};

/// Derivatives 0 to 4 of x^2 P_k(2 x - 1) for all k < n (a column each).
MatrixXd ritz_functions(double x, Index n) {
  // Derivatives of Legendre's polynomials to x, from (k + 1) P_{k+1} = (2 k + 1) t P_k - k P_{k-1}.
  MatrixXd P = MatrixXd::Zero(5, n);
  const double t = 2 * x - 1;
  for (Index k = 0; k < n; ++k) {
    for (Index d = 0; d < 5; ++d) {
      if (k == 0) {
        P(d, k) = d == 0 ? 1 : 0;
        continue;
      }
      const double c = static_cast<double>(k);
      double value = (2 * c - 1) * t * P(d, k - 1);
      if (d > 0) value += (2 * c - 1) * 2 * static_cast<double>(d) * P(d - 1, k - 1);
      if (k > 1) value -= (c - 1) * P(d, k - 2);
      P(d, k) = value / c;
    }
  }
  MatrixXd f(5, n);
  for (Index d = 0; d < 5; ++d) {
    const double c = static_cast<double>(d);
    f.row(d) = x * x * P.row(d);
    if (d > 0) f.row(d) += 2 * c * x * P.row(d - 1);
    if (d > 1) f.row(d) += c * (c - 1) * P.row(d - 2);
  }
  return f;
}

}  // namespace

RotatingBeam rotating_beam(double gamma) {
  const Index n = 16;
  const Gauss gauss(24);
  MatrixXd K = MatrixXd::Zero(n, n), M = K, fourth = K, tension = K, shortening = K;
  for (Index i = 0; i < gauss.x.size(); ++i) {
    const double x = gauss.x(i), w = gauss.w(i), T = gamma * gamma * (1 - x * x) / 2;
    const MatrixXd f = ritz_functions(x, n);
    K += w * (f.row(2).transpose() * f.row(2) + T * f.row(1).transpose() * f.row(1));
    M += w * f.row(0).transpose() * f.row(0);
    fourth += w * f.row(4).transpose() * f.row(4);
    tension += w * T * f.row(2).transpose() * f.row(2);
    shortening -= w * gamma * gamma * x * 6 * f.row(2).transpose() * f.row(3);
  }
  // The solver normalises v^T M v = 1.
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(K, M);
  const VectorXd v = solver.eigenvectors().col(0);
  const double square = solver.eigenvalues()(0);
  return {std::sqrt(square), std::sqrt(square - gamma * gamma), v.dot(fourth * v),
          v.dot(tension * v), v.dot(shortening * v)};
}

double lateral_buckling_load() {
  // a'' + P^2 (1 - x)^2 a = 0 with a = 0 at the root and a' = 0 at the tip: with s = 1 - x the even
  // solution is the sum of c_k s^{4 k}, c_k = -P^2 c_{k-1} / (4 k (4 k - 1)), and it vanishes at
  // s = 1.
  const auto value = [](double P) {
    double sum = 1, term = 1;
    for (int k = 1; k < 40; ++k) {
      term *= -P * P / (4.0 * k * (4.0 * k - 1));
      sum += term;
    }
    return sum;
  };
  double low = 3, high = 5;
  for (int i = 0; i < 100; ++i) {
    const double middle = (low + high) / 2;
    (value(middle) > 0 ? low : high) = middle;
  }
  return low;
}

double lateral_buckling_by_ritz(int n) {
  const double h = 1.0 / n;
  const Gauss gauss(5);
  MatrixXd K = MatrixXd::Zero(3 * n + 3, 3 * n + 3), G = K;
  for (int k = 0; k < n; ++k) {
    for (Index i = 0; i < gauss.x.size(); ++i) {
      const double s = gauss.x(i), w = gauss.w(i) * h, moment = 1 - (k + s) * h;
      Eigen::Vector<double, 6> bending, twist, twist_rate;
      bending << (12 * s - 6) / (h * h), (6 * s - 4) / h, 0, (6 - 12 * s) / (h * h),
          (6 * s - 2) / h, 0;
      twist << 0, 0, 1 - s, 0, 0, s;
      twist_rate << 0, 0, -1 / h, 0, 0, 1 / h;
      K.block<6, 6>(3 * k, 3 * k) +=
          w * (bending * bending.transpose() + twist_rate * twist_rate.transpose());
      G.block<6, 6>(3 * k, 3 * k) +=
          w * moment * (bending * twist.transpose() + twist * bending.transpose());
    }
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(
      G.bottomRightCorner(3 * n, 3 * n), K.bottomRightCorner(3 * n, 3 * n));
  return 1 / solver.eigenvalues().maxCoeff();
}

}  // namespace stillframe::verification
