#include "core/numerics/lanczos.hpp"

#include <Spectra/SymEigsSolver.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A map as Spectra asks for it, without what was found before: T - V diag(values) V^T B.
class Deflated {
 public:
  using Scalar = double;
  Deflated(Index n, const LinearMap& map) : n_(n), map_(map) {}
  void take_away(const VectorXd& values, const MatrixXd& vectors, const MatrixXd& B_vectors) {
    values_ = values;
    vectors_ = vectors;
    B_vectors_ = B_vectors;
  }
  Index rows() const { return n_; }
  Index cols() const { return n_; }
  void perform_op(const double* in, double* out) const {
    const Eigen::Map<const VectorXd> x(in, n_);
    VectorXd y(n_);
    map_(x, y);
    if (values_.size() > 0) {
      y -= vectors_ * values_.cwiseProduct(B_vectors_.transpose() * x);
    }
    Eigen::Map<VectorXd>(out, n_) = y;
  }

 private:
  Index n_;
  const LinearMap& map_;
  VectorXd values_;
  MatrixXd vectors_, B_vectors_;
};

/// Rounding leaves some 1e-16 of the largest; a Ritz value is known to the square of its vector.
constexpr double tolerance = 1e-11;
constexpr Index most_restarts = 300;

LanczosPairs one_run(const Deflated& T, const Deflated& B, Index n_pairs, Largest order,
                     const VectorXd& start) {
  const Index n = T.rows(), n_basis = std::min(n, 2 * n_pairs + 20);
  Deflated op = T;
  Spectra::SymEigsBase<Deflated, Deflated> solver(op, B, n_pairs, n_basis);
  solver.init(start.data());
  const auto rule =
      order == Largest::modulus ? Spectra::SortRule::LargestMagn : Spectra::SortRule::LargestAlge;
  const Index n_converged = solver.compute(rule, most_restarts, tolerance, rule);
  return {solver.eigenvalues(), solver.eigenvectors(), n_converged >= n_pairs};
}

double rank_of(double value, Largest order) {
  return order == Largest::modulus ? std::abs(value) : value;
}

/// Both sets, best first.
LanczosPairs joined(const LanczosPairs& a, const LanczosPairs& b, Largest order) {
  const Index n_a = a.values.size(), n_b = b.values.size();
  VectorXd values(n_a + n_b);
  values << a.values, b.values;
  std::vector<Index> by_rank(static_cast<size_t>(n_a + n_b));
  std::iota(by_rank.begin(), by_rank.end(), 0);
  std::stable_sort(by_rank.begin(), by_rank.end(), [&](Index i, Index j) {
    return rank_of(values(i), order) > rank_of(values(j), order);
  });
  LanczosPairs all{VectorXd(n_a + n_b),
                   MatrixXd(std::max(a.vectors.rows(), b.vectors.rows()), n_a + n_b),
                   a.converged && b.converged};
  for (Index i = 0; i < n_a + n_b; ++i) {
    const Index from = by_rank[static_cast<size_t>(i)];
    all.values(i) = values(from);
    all.vectors.col(i) = from < n_a ? a.vectors.col(from) : b.vectors.col(from - n_a);
  }
  return all;
}

}  // namespace

LanczosPairs largest_pairs(Index n, Index n_pairs, Largest order, const LinearMap& T,
                           const LinearMap& B) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Deflated rest(n, T);
  const Deflated inner(n, B);
  // From within the range of T, where B is definite.
  const auto start = [&]() -> VectorXd {
    VectorXd x(n), y(n);
    for (double& entry : x) entry = normal(random);
    rest.perform_op(x.data(), y.data());
    return y;
  };
  LanczosPairs found = one_run(rest, inner, n_pairs, order, start());
  while (found.converged) {
    MatrixXd B_vectors(n, found.values.size());
    for (Index i = 0; i < found.values.size(); ++i) {
      inner.perform_op(found.vectors.col(i).data(), B_vectors.col(i).data());
    }
    rest.take_away(found.values, found.vectors, B_vectors);
    const LanczosPairs missed = one_run(rest, inner, 1, order, start());
    // What is no larger than the last one is the next one, and no miss.
    const double last = rank_of(found.values(found.values.size() - 1), order);
    if (missed.values.size() == 0 ||
        rank_of(missed.values(0), order) <= last + 1e-9 * std::abs(last)) {
      break;
    }
    found = joined(found, missed, order);
    found.values.conservativeResize(n_pairs);
    found.vectors.conservativeResize(Eigen::NoChange, n_pairs);
  }
  return found;
}

}  // namespace stillframe
