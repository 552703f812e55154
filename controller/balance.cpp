#include "controller/balance.hpp"

#include <cmath>

namespace stillframe::controller {

using Eigen::Index;

namespace {

// One state: the power of two that brings the norms of its column and row together, if that pays.
bool balance_state(Eigen::MatrixXd& A, Index i) {
  const double column = A.col(i).lpNorm<1>() - std::abs(A(i, i));
  const double row = A.row(i).lpNorm<1>() - std::abs(A(i, i));
  if (!(column > 0) || !(row > 0)) return false;
  const double scale = std::exp2(std::round(std::log2(row / column) / 2));
  if (column * scale + row / scale >= 0.95 * (column + row)) return false;
  A.col(i) *= scale;
  A.row(i) /= scale;
  return true;
}

}  // namespace

Eigen::MatrixXd balanced(Eigen::MatrixXd A) {
  bool changed = true;
  // Every change lowers the norm by a fixed part, so this ends; the bound is for matrices of zeros
  // and infinities.
  for (int sweep = 0; changed && sweep < 100; ++sweep) {
    changed = false;
    for (Index i = 0; i < A.rows(); ++i) changed = balance_state(A, i) || changed;
  }
  return A;
}

}  // namespace stillframe::controller
