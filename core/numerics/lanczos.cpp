#include "core/numerics/lanczos.hpp"

#include <Spectra/SymEigsSolver.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>
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
/// Three are many, but where rounding keeps the last from ending.
constexpr Index most_restarts = 30;

Index basis_for(Index n_pairs) { return 2 * n_pairs + 20; }

LanczosPairs one_run(const Deflated& T, const Deflated& B, Index n_pairs, Largest order,
                     const VectorXd& start) {
  const Index n_basis = std::min(T.rows(), basis_for(n_pairs));
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

/// The best n_pairs of some, best first.
LanczosPairs best(const VectorXd& values, const MatrixXd& vectors, Index n_pairs, Largest order) {
  std::vector<Index> by_rank(static_cast<size_t>(values.size()));
  std::iota(by_rank.begin(), by_rank.end(), 0);
  std::stable_sort(by_rank.begin(), by_rank.end(), [&](Index i, Index j) {
    return rank_of(values(i), order) > rank_of(values(j), order);
  });
  by_rank.resize(static_cast<size_t>(std::min(n_pairs, values.size())));
  return {values(by_rank), vectors(Eigen::all, by_rank), true};
}

/// Whether T v = theta v, to the accuracy of the stopping test: of the pairs below a size.
bool solve_it(const LinearMap& T, const LanczosPairs& pairs, double below = INFINITY) {
  for (Index i = 0; i < pairs.values.size(); ++i) {
    if (std::abs(pairs.values(i)) > below) continue;
    const VectorXd v = pairs.vectors.col(i);
    VectorXd T_v(v.size());
    T(v, T_v);
    const double size = std::abs(pairs.values(i)) * v.norm();
    if (!((T_v - pairs.values(i) * v).norm() <= 1e-6 * size)) return false;
  }
  return true;
}

/// By Lanczos, with runs after the first for what it has missed: a Krylov space of one start has
/// one vector of each multiple eigenvalue. Errors: std::runtime_error of Spectra where the space
/// ends before it is as large as the basis.
LanczosPairs by_lanczos(Index n, Index n_pairs, Largest order, const LinearMap& T,
                        const LinearMap& B) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  double scale = 1;
  const LinearMap scaled = [&](const VectorXd& x, VectorXd& y) {
    T(x, y);
    y *= scale;
  };
  Deflated rest(n, scaled);
  const Deflated inner(n, B);
  // From within the range of T, where B is definite.
  const auto start = [&]() -> VectorXd {
    VectorXd x(n), y(n);
    for (double& entry : x) entry = normal(random);
    rest.perform_op(x.data(), y.data());
    return y;
  };
  {
    // Spectra asks of every value that its error is below tolerance times the larger of itself and
    // 3.7e-11: with the largest here that is 1e-15 of the largest, which is rounding.
    constexpr double largest = 3.7e-7;
    const VectorXd once = start();
    VectorXd twice(n);
    T(once, twice);
    if (twice.norm() > 0) scale = largest * once.norm() / twice.norm();
  }
  LanczosPairs found = one_run(rest, inner, n_pairs, order, start());
  while (found.converged) {
    MatrixXd B_vectors(n, found.values.size());
    for (Index i = 0; i < found.values.size(); ++i) {
      inner.perform_op(found.vectors.col(i).data(), B_vectors.col(i).data());
    }
    rest.take_away(found.values, found.vectors, B_vectors);
    const LanczosPairs missed = one_run(rest, inner, 1, order, start());
    // Without an answer nobody knows whether some were missed.
    if (!missed.converged && missed.values.size() == 0) {
      found.converged = false;
      break;
    }
    // What is no larger than the last one is the next one, and no miss.
    const double last = rank_of(found.values(found.values.size() - 1), order);
    if (rank_of(missed.values(0), order) <= last + 1e-9 * std::abs(last)) {
      break;
    }
    // Beside eigenvalues that are larger by all digits their rounding is taken for others.
    if (!solve_it(scaled, missed)) {
      found.converged = false;
      break;
    }
    VectorXd values(found.values.size() + 1);
    values << found.values, missed.values(0);
    MatrixXd vectors(n, values.size());
    vectors << found.vectors, missed.vectors.col(0);
    found = best(values, vectors, n_pairs, order);
  }
  // Beside values a million times as large the stopping test says little of them.
  if (found.converged && found.values.size() > 0) {
    found.converged = solve_it(scaled, found, 1e-6 * std::abs(found.values(0)));
  }
  found.values /= scale;
  return found;
}

/// R of A = R R^T, whose rounding is that of each diagonal entry and not of the largest.
MatrixXd root_of(const MatrixXd& positive) {
  const Eigen::LDLT<MatrixXd> factors(positive);
  const MatrixXd L = factors.matrixL();
  return factors.transpositionsP().transpose() *
         MatrixXd(L * factors.vectorD().cwiseMax(0).cwiseSqrt().asDiagonal());
}

/// From S^-1 on the coordinates of A alone.
LanczosPairs by_few_coordinates(const Eigen::SparseMatrix<double>& A,
                                const std::vector<Index>& coordinates, Index n_pairs, Largest order,
                                const LinearMap& solve, bool A_is_metric) {
  const Index n = A.rows(), n_few = static_cast<Index>(coordinates.size());
  MatrixXd columns(n, n_few);  // of S^-1
  VectorXd unit = VectorXd::Zero(n), column(n);
  for (Index j = 0; j < n_few; ++j) {
    const Index at = coordinates[static_cast<size_t>(j)];
    unit(at) = 1;
    solve(unit, column);
    unit(at) = 0;
    columns.col(j) = column;
  }
  MatrixXd few(n_few, n_few);
  for (Index j = 0; j < n_few; ++j) {
    few.col(j) = VectorXd(A.col(coordinates[static_cast<size_t>(j)]))(coordinates);
  }
  const MatrixXd F = columns(coordinates, Eigen::all), symmetric = 0.5 * (F + F.transpose());
  // Of A u = R R^T u, or S^-1 = R R^T, the eigenvectors y of R^T (the other) R: R y is the force A
  // u, or the motion u, and v = S^-1 A u / theta.
  const MatrixXd R = root_of(A_is_metric ? few : symmetric);
  const MatrixXd product = R.transpose() * (A_is_metric ? symmetric : few) * R;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(0.5 * (product + product.transpose()));
  LanczosPairs found = best(solver.eigenvalues(), solver.eigenvectors(), n_pairs, order);
  // Rounding of the largest is no eigenvalue.
  const double least = 1e-15 * solver.eigenvalues().cwiseAbs().maxCoeff();
  Index n_found = 0;
  while (n_found < found.values.size() && rank_of(found.values(n_found), order) > least) ++n_found;
  found.values.conservativeResize(n_found);
  const MatrixXd forces = A_is_metric ? MatrixXd(R * found.vectors.leftCols(n_found))
                                      : MatrixXd(few * R * found.vectors.leftCols(n_found));
  found.vectors = columns * forces * found.values.cwiseInverse().asDiagonal();
  return found;
}

}  // namespace

LanczosPairs largest_pairs(const Eigen::SparseMatrix<double>& A, Index n_pairs, Largest order,
                           const LinearMap& solve, const LinearMap& S, bool in_any_time) {
  const Index n = A.rows();
  std::vector<Index> coordinates;
  for (Index j = 0; j < n; ++j) {
    if (Eigen::SparseMatrix<double>::InnerIterator(A, j)) coordinates.push_back(j);
  }
  const auto n_few = static_cast<Index>(coordinates.size());
  const auto dense = [&] { return by_few_coordinates(A, coordinates, n_pairs, order, solve, !S); };
  constexpr Index few = 300, most_dense = 3000;
  if (n_few <= std::max(few, 2 * basis_for(n_pairs))) return dense();
  VectorXd A_x(n);
  const LinearMap T = [&](const VectorXd& x, VectorXd& y) {
    A_x.noalias() = A * x;
    solve(A_x, y);
  };
  const LinearMap metric = [&](const VectorXd& x, VectorXd& y) { y.noalias() = A * x; };
  try {
    LanczosPairs found = by_lanczos(n, n_pairs, order, T, S ? S : metric);
    // Where a Krylov space ends Spectra goes on with any vector, also one on which S is not defined
    // (it breaks conditions that S^-1 knows of).
    if (S && !solve_it(T, found)) throw std::runtime_error("no eigenvectors");
    if (!found.converged && in_any_time && n_few <= most_dense) return dense();
    return found;
  } catch (const std::runtime_error&) {
    // What moves is less than the coordinates of A: most of them hang together.
    return n_few <= most_dense ? dense() : LanczosPairs{};
  }
}

}  // namespace stillframe
