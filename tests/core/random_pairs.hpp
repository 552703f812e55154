#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <random>

#include "core/control/design/design_model.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/differences.hpp"

namespace stillframe::test {

/// Orthogonal, every orientation as likely as any other: the Q of a normal matrix, with the signs
/// that make R positive.
inline Eigen::MatrixXd random_orthogonal(Eigen::Index n, std::mt19937& engine) {
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd A =
      Eigen::MatrixXd::NullaryExpr(n, n, [&]() -> double { return normal(engine); });
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(A);
  const Eigen::MatrixXd Q = qr.householderQ();
  return Q * qr.matrixQR().diagonal().cwiseSign().asDiagonal();
}

/// Symmetric, positive definite; eigenvalues from 1 to `condition`, both ends taken, the others
/// evenly likely on a logarithmic axis.
inline Eigen::MatrixXd random_spd(Eigen::Index n, double condition, std::mt19937& engine) {
  std::uniform_real_distribution<double> exponent(0, std::log(condition));
  Eigen::VectorXd values(n);
  for (double& value : values) value = std::exp(exponent(engine));
  values(0) = 1;
  values(n - 1) = n > 1 ? condition : 1;
  const Eigen::MatrixXd Q = random_orthogonal(n, engine);
  const Eigen::MatrixXd S = Q * values.asDiagonal() * Q.transpose();
  return 0.5 * (S + S.transpose());
}

/// The roots of s^2 + 2 zeta omega_d s + omega_d^2; of a pair the one above the real axis, or the
/// two real ones.
inline std::array<std::complex<double>, 2> target_roots(double omega_d, double zeta) {
  if (zeta < 1) {
    const std::complex<double> root(-zeta, std::sqrt(1 - zeta * zeta));
    return {omega_d * root, omega_d * std::conj(root)};
  }
  const double large = zeta + std::sqrt(zeta * zeta - 1);
  return {-omega_d / large, -omega_d * large};
}

/// Largest distance of the poles from the two roots of the target, as part of the root itself; each
/// root is to have as many poles as the other, or the answer is infinity.
inline double distance_from_target(const Eigen::VectorXcd& poles, double omega_d, double zeta) {
  const auto roots = target_roots(omega_d, zeta);
  double worst = 0;
  Eigen::Index at_first = 0;
  for (const std::complex<double> pole : poles) {
    const double first = std::abs(pole - roots[0]) / std::abs(roots[0]);
    const double second = std::abs(pole - roots[1]) / std::abs(roots[1]);
    if (first < second) ++at_first;
    // Where both roots are one the poles belong to both.
    worst = worst_of(worst, std::min(first, second));
  }
  const bool split = roots[0] == roots[1] || 2 * at_first == poles.size();
  return split ? worst : std::numeric_limits<double>::infinity();
}

}  // namespace stillframe::test
