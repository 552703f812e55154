#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

namespace stillframe::nodal {

using Eigen::Index;

/// Groups of unknowns that meet in one element or one mass.
using Groups = std::vector<std::vector<Index>>;

/// Where each of n unknowns stands (n) so that those of one group stand close together: the reverse
/// Cuthill-McKee ordering from an unknown at the rim (A. George, J. W. H. Liu, Computer solution of
/// large sparse positive definite systems, 1981, chapter 4). set-up.
std::vector<Index> narrow_ordering(Index n, const Groups& groups);

/// Largest distance between two unknowns of one group. set-up.
Index half_bandwidth(const std::vector<Index>& place, const Groups& groups);

/// A square matrix (n x n) whose entries vanish further than b from the diagonal. Set-up:
/// construction; the rest is hot: noexcept, no allocation.
class BandMatrix {
 public:
  BandMatrix(Index n, Index b);
  void set_zero() noexcept { values_.setZero(); }
  /// Adds to an entry not further than b from the diagonal.
  void add(Index row, Index column, double value) noexcept {
    values_(b_ + row - column, column) += value;
  }
  /// y += A x.
  void add_product(const Eigen::VectorXd& x, Eigen::VectorXd& y) const noexcept;
  Index size() const noexcept { return values_.cols(); }
  Index half_bandwidth() const noexcept { return b_; }
  const Eigen::MatrixXd& values() const noexcept { return values_; }

 private:
  Index b_;
  Eigen::MatrixXd values_;  ///< (2 b + 1) x n, entry (i, j) in row b + i - j
};

/// P A = L U of a band matrix by elimination with row exchanges, for Scalar double or
/// std::complex<double>. Set-up: construction; the rest is hot: noexcept, no allocation.
template <class Scalar>
class BandFactors {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  BandFactors(Index n, Index b);
  /// Factorises A_0 + c A_1 + c^2 A_2; false if that is singular or not finite.
  bool factorise(const BandMatrix& A_0, Scalar c, const BandMatrix& A_1,
                 const BandMatrix& A_2) noexcept;
  bool factorise(const BandMatrix& A) noexcept;
  /// x = A^-1 x in place (n).
  void solve(Vector& x) const noexcept;

 private:
  bool eliminate() noexcept;
  void exchange(Index k, Index pivot) noexcept;

  Index b_;
  /// (3 b + 1) x n, entry (i, j) in row 2 b + i - j
  Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> values_;
  std::vector<Index> pivots_;
};

}  // namespace stillframe::nodal
