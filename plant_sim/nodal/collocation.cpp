#include "plant_sim/nodal/collocation.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace stillframe::nodal {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// P_n(x) and P_n'(x) of Legendre, |x| < 1.
std::pair<double, double> legendre(Index n, double x) {
  double before = 0, p = 1;
  for (Index k = 0; k < n; ++k) {
    const auto j = static_cast<double>(k);
    const double next = ((2 * j + 1) * x * p - j * before) / (j + 1);
    before = p;
    p = next;
  }
  return {p, static_cast<double>(n) * (before - x * p) / (1 - x * x)};
}

/// Roots of P_s - P_(s-1) moved to [0, 1]: the right end is one of them.
VectorXd radau_nodes(Index s) {
  VectorXd c(s);
  c(s - 1) = 1;
  for (Index i = 0; i + 1 < s; ++i) {
    double x = -std::cos(std::numbers::pi * (2.0 * static_cast<double>(i) + 1) /
                         (2.0 * static_cast<double>(s) - 1));
    for (int iteration = 0; iteration < 100; ++iteration) {
      const auto [p, dp] = legendre(s, x);
      const auto [q, dq] = legendre(s - 1, x);
      // The root at 1 is taken out, so that none runs there.
      const double f = (p - q) / (x - 1), df = (dp - dq) / (x - 1) - f / (x - 1);
      x -= f / df;
    }
    c(i) = 0.5 * (1 + x);
  }
  std::sort(c.begin(), c.end());
  return c;
}

/// Entries (i, k) = c_i^k.
MatrixXd powers(const VectorXd& c) {
  MatrixXd V(c.size(), c.size());
  for (Index k = 0; k < c.size(); ++k) V.col(k) = c.array().pow(static_cast<double>(k));
  return V;
}

}  // namespace

Collocation::Collocation(Index stages) {
  if (stages < 1 || stages % 2 == 0) {
    throw std::invalid_argument("Collocation: expected an odd number of stages, got " +
                                std::to_string(stages));
  }
  const Index s = stages;
  c = radau_nodes(s);
  const MatrixXd V = powers(c);
  MatrixXd integrals(s, s);
  for (Index k = 0; k < s; ++k) {
    integrals.col(k) = c.array().pow(static_cast<double>(k + 1)) / static_cast<double>(k + 1);
  }
  const Eigen::FullPivLU<MatrixXd> lu(V.transpose());
  A = lu.solve(integrals.transpose()).transpose();
  A_2 = A * A;

  const Eigen::EigenSolver<MatrixXd> eigen(A);
  const Eigen::MatrixXcd vectors = eigen.eigenvectors(), inverse = vectors.inverse();
  std::vector<Index> pairs;
  for (Index i = 0; i < s; ++i) {
    const std::complex<double> value = eigen.eigenvalues()(i);
    if (value.imag() == 0) {
      gamma = value.real();
      // The eigenvector of a real eigenvalue is real, up to the factor that the inverse undoes.
      T_real = vectors.col(i).real();
      T_inverse_real = inverse.row(i).real();
    } else if (value.imag() > 0) {
      mu.push_back(value);
      pairs.push_back(i);
    }
  }
  T.resize(s, static_cast<Index>(pairs.size()));
  T_inverse.resize(static_cast<Index>(pairs.size()), s);
  for (size_t k = 0; k < pairs.size(); ++k) {
    T.col(static_cast<Index>(k)) = vectors.col(pairs[k]);
    T_inverse.row(static_cast<Index>(k)) = inverse.row(pairs[k]);
  }
  VectorXd moments = VectorXd::Zero(s);
  moments(0) = -gamma;
  d = lu.solve(moments);
  d_A = A.transpose() * d;
  coefficients = V.inverse();
}

void Collocation::extrapolate(
    double t, Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> weights) const noexcept {
  weights.setZero();
  double power = 1;
  for (Index k = 0; k < coefficients.rows(); ++k, power *= t) {
    weights += power * coefficients.row(k);
  }
}

}  // namespace stillframe::nodal
