#include "core/mechanics/sparse/mixed_factors.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

namespace stillframe {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

double inverse_or_one(double largest) { return largest > 0 ? 1 / largest : 1; }

}  // namespace

template <class Scalar>
bool MixedFactors<Scalar>::compute(const SparseMatrix& E, const Vector& compliance,
                                   const Eigen::SparseMatrix<Scalar>& A) {
  const Index n_s = E.rows(), n_c = E.cols(), n = n_s + n_c;
  column_scale_ = VectorXd::Zero(n_c);
  row_scale_ = VectorXd::Zero(n_s);
  for (Index j = 0; j < n_c; ++j) {
    for (SparseMatrix::InnerIterator it(E, j); it; ++it) {
      column_scale_(j) = std::max(column_scale_(j), std::abs(it.value()));
    }
  }
  column_scale_ = column_scale_.unaryExpr(&inverse_or_one);
  for (Index j = 0; j < n_c; ++j) {
    for (SparseMatrix::InnerIterator it(E, j); it; ++it) {
      double& largest = row_scale_(it.row());
      largest = std::max(largest, std::abs(it.value()) * column_scale_(j));
    }
  }
  row_scale_ = row_scale_.unaryExpr(&inverse_or_one);
  const Vector scaled = compliance.cwiseProduct(row_scale_.cwiseAbs2().template cast<Scalar>());
  std::vector<double> elastic;
  for (const Scalar& c : scaled) {
    if (std::abs(c) > 0) elastic.push_back(std::abs(c));
  }
  unit_ = 1;
  if (!elastic.empty()) {
    const auto middle = elastic.begin() + static_cast<std::ptrdiff_t>(elastic.size() / 2);
    std::nth_element(elastic.begin(), middle, elastic.end());
    unit_ = 1e-7 / *middle;
  }
  std::vector<Eigen::Triplet<Scalar>> entries;
  entries.reserve(static_cast<size_t>(n_s + 2 * E.nonZeros() + A.nonZeros()));
  for (Index i = 0; i < n_s; ++i) {
    if (compliance(i) != Scalar(0)) entries.emplace_back(i, i, -unit_ * scaled(i));
  }
  for (Index j = 0; j < n_c; ++j) {
    for (SparseMatrix::InnerIterator it(E, j); it; ++it) {
      const double entry = it.value() * row_scale_(it.row()) * column_scale_(j);
      entries.emplace_back(it.row(), n_s + j, entry);
      entries.emplace_back(n_s + j, it.row(), entry);
    }
    for (typename Eigen::SparseMatrix<Scalar>::InnerIterator it(A, j); it; ++it) {
      entries.emplace_back(n_s + it.row(), n_s + j,
                           it.value() * column_scale_(it.row()) * column_scale_(j) / unit_);
    }
  }
  matrix_.resize(n, n);
  matrix_.setFromTriplets(entries.begin(), entries.end());
  matrix_.makeCompressed();
  lu_.analyzePattern(matrix_);
  lu_.factorize(matrix_);
  return lu_.info() == Eigen::Success;
}

template <class Scalar>
bool MixedFactors<Scalar>::singular() const {
  // Entries are at most one. Chains of 30 000 beams reach 1e10; what is singular, what rounding
  // leaves of a pivot, 1e16.
  constexpr double most = 1e14;
  Vector right(matrix_.rows());
  for (Index i = 0; i < right.size(); ++i) right(i) = i % 3 == 0 ? -1 : 1;
  const Vector solution = lu_.solve(right);
  return !(solution.cwiseAbs().maxCoeff() < most);
}

template <class Scalar>
void MixedFactors<Scalar>::solve(const Vector& e, const Vector& f, Vector& s, Vector& x) const {
  const Index n_s = row_scale_.size(), n_c = column_scale_.size();
  const Vector rows = row_scale_.cast<Scalar>(), columns = column_scale_.cast<Scalar>();
  Vector right(n_s + n_c);
  if (e.size() > 0) {
    right.head(n_s) = e.cwiseProduct(rows);
  } else {
    right.head(n_s).setZero();
  }
  right.tail(n_c) = f.cwiseProduct(columns) / unit_;
  Vector solution = lu_.solve(right);
  right -= matrix_ * solution;
  solution += lu_.solve(right);
  s = unit_ * solution.head(n_s).cwiseProduct(rows);
  x = solution.tail(n_c).cwiseProduct(columns);
}

template class MixedFactors<double>;
template class MixedFactors<std::complex<double>>;

}  // namespace stillframe
