#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>

#include "core/systems/state_space_model.hpp"

namespace stillframe::test {

__extension__ typedef __float128 Quad;  ///< 113 bits, relative rounding 1e-34

inline Quad sqrt_of(Quad a) {
  if (!(a > 0)) return 0;
  Quad root = std::sqrt(static_cast<long double>(a));
  for (int i = 0; i < 2; ++i) root = (root + a / root) / 2;
  return root;
}
inline Quad abs_of(Quad a) { return a < 0 ? -a : a; }

}  // namespace stillframe::test

namespace stillframe::test {

using QuadMatrix = Eigen::Matrix<Quad, Eigen::Dynamic, Eigen::Dynamic>;

/// Complex matrices are kept as real ones, [Re -Im; Im Re], which have every singular value twice.
inline QuadMatrix embedded(const Eigen::MatrixXcd& Z) {
  QuadMatrix out(2 * Z.rows(), 2 * Z.cols());
  out << Z.real().cast<Quad>(), -Z.imag().cast<Quad>(), Z.imag().cast<Quad>(),
      Z.real().cast<Quad>();
  return out;
}

inline Eigen::MatrixXcd rounded(const QuadMatrix& Z) {
  const Eigen::Index p = Z.rows() / 2, m = Z.cols() / 2;
  Eigen::MatrixXcd out(p, m);
  out.real() = Z.topLeftCorner(p, m).cast<double>();
  out.imag() = Z.bottomLeftCorner(p, m).cast<double>();
  return out;
}

/// X of A X = B by Gauss-Jordan elimination with partial pivoting.
inline QuadMatrix solve(QuadMatrix A, QuadMatrix B) {
  for (Eigen::Index k = 0; k < A.rows(); ++k) {
    Eigen::Index pivot = k;
    for (Eigen::Index i = k; i < A.rows(); ++i) {
      if (abs_of(A(i, k)) > abs_of(A(pivot, k))) pivot = i;
    }
    A.row(k).swap(A.row(pivot));
    B.row(k).swap(B.row(pivot));
    for (Eigen::Index i = 0; i < A.rows(); ++i) {
      if (i == k || A(i, k) == 0) continue;
      const Quad factor = A(i, k) / A(k, k);
      A.row(i) -= factor * A.row(k);
      B.row(i) -= factor * B.row(k);
    }
  }
  for (Eigen::Index k = 0; k < A.rows(); ++k) B.row(k) /= A(k, k);
  return B;
}

/// G(s) of the numbers in the state space, embedded: 2 p x 2 m.
inline QuadMatrix quadruple_transfer(const StateSpace& system, std::complex<double> s) {
  using Kind = InputColumns::Kind;
  const Eigen::Index n = system.A.rows(), columns = system.B.cols();
  const auto m = static_cast<Eigen::Index>(system.columns.size());
  const Quad re = s.real(), im = s.imag(), square = re * re + im * im;
  QuadMatrix S = QuadMatrix::Zero(2 * n, 2 * n);
  S.topLeftCorner(n, n) = S.bottomRightCorner(n, n) = -system.A.cast<Quad>();
  for (Eigen::Index i = 0; i < n; ++i) {
    S(i, i) += re;
    S(n + i, n + i) += re;
    S(n + i, i) += im;
    S(i, n + i) -= im;
  }
  QuadMatrix factors = QuadMatrix::Zero(2 * columns, 2 * m);
  for (Eigen::Index j = 0; j < m; ++j) {
    const InputColumns& input = system.columns[static_cast<size_t>(j)];
    const int top = input.kind == Kind::position ? 2 : input.kind == Kind::velocity ? 1 : 0;
    for (Eigen::Index i = 0; i < input.width(); ++i) {
      Quad p_r = 1, p_i = 0;  // s^power
      for (int power = top - static_cast<int>(i); power != 0; power += power < 0 ? 1 : -1) {
        const bool up = power > 0;
        const Quad f_r = up ? re : re / square, f_i = up ? im : -im / square;
        const Quad next = p_r * f_r - p_i * f_i;
        p_i = p_r * f_i + p_i * f_r;
        p_r = next;
      }
      const Eigen::Index row = input.first + i;
      factors(row, j) = factors(columns + row, m + j) = p_r;
      factors(columns + row, j) = p_i;
      factors(row, m + j) = -p_i;
    }
  }
  const auto twice = [](const Eigen::MatrixXd& X) {
    QuadMatrix out = QuadMatrix::Zero(2 * X.rows(), 2 * X.cols());
    out.topLeftCorner(X.rows(), X.cols()) = out.bottomRightCorner(X.rows(), X.cols()) =
        X.cast<Quad>();
    return out;
  };
  return twice(system.C) * solve(S, twice(system.B) * factors) + twice(system.D) * factors;
}

/// Singular values of an embedded matrix, largest first, each once: one-sided Jacobi, 113 bits.
inline Eigen::VectorXd quadruple_singular_values(QuadMatrix Z) {
  if (Z.rows() < Z.cols()) Z.transposeInPlace();
  const Quad tolerance = 1e-31;
  for (bool turned = true; turned;) {
    turned = false;
    for (Eigen::Index i = 0; i < Z.cols(); ++i) {
      for (Eigen::Index j = i + 1; j < Z.cols(); ++j) {
        const Quad a = Z.col(i).squaredNorm(), b = Z.col(j).squaredNorm(),
                   g = Z.col(i).dot(Z.col(j));
        if (!(abs_of(g) > tolerance * sqrt_of(a) * sqrt_of(b))) continue;
        turned = true;
        const Quad half = (b - a) / 2, root = sqrt_of(half * half + g * g);
        const Quad t = g / (half < 0 ? half - root : half + root), c = 1 / sqrt_of(1 + t * t);
        const Eigen::Matrix<Quad, Eigen::Dynamic, 1> x = Z.col(i);
        Z.col(i) = c * x - c * t * Z.col(j);
        Z.col(j) = c * t * x + c * Z.col(j);
      }
    }
  }
  Eigen::VectorXd twice(Z.cols());
  for (Eigen::Index j = 0; j < Z.cols(); ++j) {
    twice(j) = static_cast<double>(sqrt_of(Z.col(j).squaredNorm()));
  }
  std::sort(twice.data(), twice.data() + twice.size(), std::greater<>());
  Eigen::VectorXd values(Z.cols() / 2);
  for (Eigen::Index j = 0; j < values.size(); ++j) values(j) = twice(2 * j);
  return values;
}

}  // namespace stillframe::test
