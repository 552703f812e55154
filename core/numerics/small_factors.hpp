#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <utility>

namespace stillframe {

/// LU factors with partial pivoting of a small matrix (n x n, n at most `most`), in plain loops: a
/// rigid body on its legs has seven unknowns, for which the blocked kernels of a library take three
/// times as long. hot: noexcept, no allocation. A singular matrix gives values that are not finite.
class SmallFactors {
 public:
  static constexpr Eigen::Index most = 24;

  void factorise(const Eigen::MatrixXd& J) noexcept {
    n_ = static_cast<int>(J.rows());
    for (int i = 0; i < n_; ++i) {
      for (int j = 0; j < n_; ++j) row(i)[j] = J(i, j);
    }
    for (int k = 0; k < n_; ++k) {
      pivot(k);
      const double* upper = row(k);
      const double inverse = 1.0 / upper[k];
      inverse_[static_cast<size_t>(k)] = inverse;
      for (int i = k + 1; i < n_; ++i) {
        double* lower = row(i);
        if (lower[k] == 0.0) continue;
        const double factor = lower[k] *= inverse;
        for (int j = k + 1; j < n_; ++j) lower[j] -= factor * upper[j];
      }
    }
  }

  /// Of the determinant of J: 1 or -1, 0 where it is zero or not finite.
  int sign() const noexcept {
    int sign = 1;
    for (int k = 0; k < n_; ++k) {
      const double pivot = row(k)[k];
      if (!std::isfinite(pivot) || pivot == 0.0) return 0;
      if ((pivot < 0) != (swapped_[static_cast<size_t>(k)] != k)) sign = -sign;
    }
    return sign;
  }

  /// J^-1 b in place; b: n rows of `columns` contiguous entries.
  void solve(double* b, Eigen::Index columns) const noexcept {
    const int m = static_cast<int>(columns);
    for (int k = 0; k < n_; ++k) {
      const int other = swapped_[static_cast<size_t>(k)];
      if (other == k) continue;
      for (int j = 0; j < m; ++j) std::swap(b[k * m + j], b[other * m + j]);
    }
    for (int i = 0; i < n_; ++i) {
      for (int k = 0; k < i; ++k) subtract(row(i)[k], b + k * m, b + i * m, m);
    }
    for (int i = n_ - 1; i >= 0; --i) {
      for (int k = i + 1; k < n_; ++k) subtract(row(i)[k], b + k * m, b + i * m, m);
      for (int j = 0; j < m; ++j) b[i * m + j] *= inverse_[static_cast<size_t>(i)];
    }
  }

 private:
  static void subtract(double factor, const double* from, double* to, int m) noexcept {
    if (factor == 0.0) return;  // most are, in the conditions of a frame
    for (int j = 0; j < m; ++j) to[j] -= factor * from[j];
  }
  double* row(int i) noexcept { return values_.data() + i * most; }
  const double* row(int i) const noexcept { return values_.data() + i * most; }
  void pivot(int k) noexcept {
    int best = k;
    for (int i = k + 1; i < n_; ++i) {
      if (std::abs(row(i)[k]) > std::abs(row(best)[k])) best = i;
    }
    swapped_[static_cast<size_t>(k)] = best;
    if (best != k) std::swap_ranges(row(k), row(k) + n_, row(best));
  }

  int n_ = 0;
  std::array<double, static_cast<size_t>(most* most)> values_{};
  std::array<double, static_cast<size_t>(most)> inverse_{};
  std::array<int, static_cast<size_t>(most)> swapped_{};
};

}  // namespace stillframe
