#pragma once

#include <Eigen/LU>
#include <Eigen/SparseLU>
#include <memory>
#include <vector>

#include "core/mechanics/model/local.hpp"
#include "core/numerics/small_factors.hpp"

namespace stillframe {

/// J = [D^(c)D^(0); D^(c)D^(m)] (n x n) and its factors, which serve every order of the geometric
/// transfer functions and, transposed, the reactions. Small matrices are dense, and then everything
/// is hot: noexcept, no allocation; above `largest_dense` the factors are sparse.
class ConditionFactors {
 public:
  /// Where dense and sparse factors of a chain of beams take the same time.
  static constexpr Index largest_dense = 120;

  /// columns: of the widest right-hand side.
  ConditionFactors(Index n, Index columns);
  /// A copy has factors of its own.
  ConditionFactors(const ConditionFactors& other);
  ConditionFactors& operator=(const ConditionFactors& other);
  ~ConditionFactors();

  void clear() noexcept;
  void add(Index row, Index column, double value) noexcept;
  void factorise() noexcept;
  Index size() const { return n_; }

  /// Of the determinant of J, after factorise(): 1 or -1, 0 if J is singular. Motion that the dofs
  /// describe keeps it: it changes where they no longer say where the nodes are.
  int sign() const noexcept;

  /// J^-1 b and J^-T b in place, b n x k.
  void solve(Eigen::VectorXd& b) noexcept;
  void solve(RowMatrix& b) noexcept;
  void solve_transposed(Eigen::VectorXd& b) const;

  /// Estimate of the smallest over the largest singular value, from a few steps of inverse
  /// iteration on the factors; 0 if J is singular.
  double reciprocal_condition() const;

  /// Largest row sum of |J^-1| |J|: how many times larger than the rounding of b that of J^-1 b may
  /// be, whatever the units of its rows (R. D. Skeel, J. ACM 26 (1979) 494-526). As dear as n
  /// solutions.
  double componentwise_condition() const;

 private:
  template <class Matrix>
  void solve_dense(Matrix& b) noexcept;
  bool small() const { return n_ <= SmallFactors::most; }
  bool dense() const { return n_ <= largest_dense; }
  /// The dense factors of a library, of what small_ has factors of its own.
  Eigen::PartialPivLU<Eigen::MatrixXd> library_factors() const;

  Index n_;
  Eigen::MatrixXd J_;
  SmallFactors small_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
  RowMatrix permuted_;
  struct Sparse;
  std::unique_ptr<Sparse> sparse_;
};

}  // namespace stillframe
