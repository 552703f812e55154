#include "core/numerics/balance.hpp"

#include <cmath>

namespace stillframe {

using Eigen::Index;

namespace {

/// One state: the power of two that brings the norms of its column and row together, or 1 if that
/// does not pay.
double scale_of(const Eigen::MatrixXd& A, Index i) {
  const double column = A.col(i).lpNorm<1>() - std::abs(A(i, i));
  const double row = A.row(i).lpNorm<1>() - std::abs(A(i, i));
  if (!(column > 0) || !(row > 0)) return 1.0;
  const double scale = std::exp2(std::round(std::log2(row / column) / 2));
  return column * scale + row / scale < 0.95 * (column + row) ? scale : 1.0;
}

}  // namespace

Eigen::VectorXd balancing_scales(Eigen::MatrixXd A) {
  Eigen::VectorXd scales = Eigen::VectorXd::Ones(A.rows());
  bool changed = true;
  // Every change lowers the norm by a fixed part, so this ends; the bound is for matrices of zeros
  // and infinities.
  for (int sweep = 0; changed && sweep < 100; ++sweep) {
    changed = false;
    for (Index i = 0; i < A.rows(); ++i) {
      const double scale = scale_of(A, i);
      if (scale == 1.0) continue;
      A.col(i) *= scale;
      A.row(i) /= scale;
      scales(i) *= scale;
      changed = true;
    }
  }
  return scales;
}

Eigen::MatrixXd balanced(const Eigen::MatrixXd& A) {
  const Eigen::VectorXd S = balancing_scales(A);
  return S.cwiseInverse().asDiagonal() * A * S.asDiagonal();
}

}  // namespace stillframe
