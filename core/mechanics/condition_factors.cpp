#include "core/mechanics/condition_factors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numerics/infinity.hpp"

namespace stillframe {

struct ConditionFactors::Sparse {
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::SparseMatrix<double> J;
  Eigen::SparseLU<Eigen::SparseMatrix<double>> lu;
  bool analysed = false, sound = false;
};

ConditionFactors::ConditionFactors(Index n, Index columns) : n_(n) {
  if (dense()) {
    J_ = Eigen::MatrixXd::Zero(n, n);
    if (!small()) lu_ = Eigen::PartialPivLU<Eigen::MatrixXd>(n);
    permuted_ = RowMatrix::Zero(n, std::max<Index>(columns, 1));
  } else {
    sparse_ = std::make_unique<Sparse>();
    sparse_->J.resize(n, n);
  }
}

ConditionFactors::ConditionFactors(const ConditionFactors& other) : n_(other.n_) { *this = other; }
ConditionFactors::~ConditionFactors() = default;

ConditionFactors& ConditionFactors::operator=(const ConditionFactors& other) {
  if (this == &other) return *this;
  n_ = other.n_;
  J_ = other.J_;
  small_ = other.small_;
  lu_ = other.lu_;
  permuted_ = other.permuted_;
  sparse_.reset();
  if (!other.sparse_) return *this;
  sparse_ = std::make_unique<Sparse>();
  sparse_->J.resize(n_, n_);
  sparse_->entries = other.sparse_->entries;
  if (other.sparse_->sound) factorise();
  return *this;
}

void ConditionFactors::clear() noexcept {
  if (dense()) {
    J_.setZero();
  } else {
    sparse_->entries.clear();
  }
}

void ConditionFactors::add(Index row, Index column, double value) noexcept {
  if (dense()) {
    J_(row, column) += value;
  } else {
    sparse_->entries.emplace_back(static_cast<int>(row), static_cast<int>(column), value);
  }
}

void ConditionFactors::factorise() noexcept {
  if (n_ == 0) return;
  if (small()) return small_.factorise(J_);
  if (dense()) {
    lu_.compute(J_);
    return;
  }
  // Entries that happen to be zero stay, so that the pattern never changes.
  sparse_->J.setFromTriplets(sparse_->entries.begin(), sparse_->entries.end());
  if (!sparse_->analysed) {
    sparse_->lu.analyzePattern(sparse_->J);
    sparse_->analysed = true;
  }
  sparse_->lu.factorize(sparse_->J);
  sparse_->sound = sparse_->lu.info() == Eigen::Success;
}

int ConditionFactors::sign() const noexcept {
  if (n_ == 0) return 1;
  if (small()) return small_.sign();
  if (!dense()) return sparse_->sound ? static_cast<int>(sparse_->lu.signDeterminant()) : 0;
  int sign = 1;
  const auto& target = lu_.permutationP().indices();
  for (Index k = 0; k < n_; ++k) {
    const double pivot = lu_.matrixLU()(k, k);
    if (!std::isfinite(pivot) || pivot == 0.0) return 0;
    // Of a permutation that of its inversions: its cycles would need memory of where one has been.
    const auto inversions = (target.tail(n_ - k - 1).array() < target(k)).count();
    if ((pivot < 0) != (inversions % 2 != 0)) sign = -sign;
  }
  return sign;
}

/// Eigen permutes in place with a mask that it allocates, so the rows go by way of work space.
template <class Matrix>
void ConditionFactors::solve_dense(Matrix& b) noexcept {
  auto permuted = permuted_.leftCols(b.cols());
  permuted = b;
  const auto& target = lu_.permutationP().indices();
  for (Index i = 0; i < b.rows(); ++i) b.row(target(i)) = permuted.row(i);
  lu_.matrixLU().template triangularView<Eigen::UnitLower>().solveInPlace(b);
  lu_.matrixLU().template triangularView<Eigen::Upper>().solveInPlace(b);
}

void ConditionFactors::solve(Eigen::VectorXd& b) noexcept {
  if (b.size() == 0) return;
  if (small()) return small_.solve(b.data(), 1);
  if (dense()) return solve_dense(b);
  if (!sparse_->sound) {
    b.setConstant(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  const Eigen::VectorXd right = b;
  b = sparse_->lu.solve(right);
}

void ConditionFactors::solve(RowMatrix& b) noexcept {
  if (b.size() == 0) return;
  if (small()) return small_.solve(b.data(), b.cols());
  if (dense()) {
    if (b.cols() <= permuted_.cols()) return solve_dense(b);
    b = lu_.solve(b).eval();
    return;
  }
  if (!sparse_->sound) {
    b.setConstant(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  const Eigen::MatrixXd columns = b;
  const Eigen::MatrixXd solution = sparse_->lu.solve(columns);
  b = solution;
}

Eigen::PartialPivLU<Eigen::MatrixXd> ConditionFactors::library_factors() const {
  return small() ? Eigen::PartialPivLU<Eigen::MatrixXd>(J_) : lu_;
}

void ConditionFactors::solve_transposed(Eigen::VectorXd& b) const {
  if (b.size() == 0) return;
  b = dense() ? Eigen::VectorXd(library_factors().transpose().solve(b))
              : Eigen::VectorXd(sparse_->lu.transpose().solve(b));
}

double ConditionFactors::reciprocal_condition() const {
  if (n_ == 0) return 1;
  if (dense()) return library_factors().rcond();
  if (!sparse_->sound) return 0;
  // Power iteration on J^-1 J^-T: the start is no eigenvector of anything regular.
  Eigen::VectorXd b(n_);
  for (Index i = 0; i < n_; ++i) b(i) = 1.0 + 0.5 * static_cast<double>(i % 7);
  double inverse_norm = 0;
  for (int step = 0; step < 4; ++step) {
    b.normalize();
    Eigen::VectorXd y = sparse_->lu.transpose().solve(b);
    b = sparse_->lu.solve(y);
    inverse_norm = std::sqrt(b.norm());
    if (!std::isfinite(inverse_norm)) return 0;
  }
  return 1.0 / (inverse_norm * sparse_->J.norm());
}

double ConditionFactors::componentwise_condition() const {
  if (n_ == 0) return 1;
  if (dense()) {
    const Eigen::MatrixXd product = library_factors().inverse().cwiseAbs() * J_.cwiseAbs();
    return product.rowwise().sum().maxCoeff();
  }
  if (!sparse_->sound) return infinity;
  const Eigen::VectorXd sizes = sparse_->J.cwiseAbs() * Eigen::VectorXd::Ones(n_);
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(n_);
  for (Index k = 0; k < n_; ++k) {
    const Eigen::VectorXd column = sparse_->lu.solve(Eigen::VectorXd::Unit(n_, k));
    sums += sizes(k) * column.cwiseAbs();
  }
  return sums.maxCoeff();
}

}  // namespace stillframe
