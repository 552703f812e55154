#pragma once

#include <Eigen/SparseLU>

#include "core/mechanics/sparse/mixed_model.hpp"

namespace stillframe {

/// Factors of the mixed form [-c, E; E^T, A] of a sparse model, so that K x + A x = f is solved
/// without K = E^T c^-1 E. Coordinates and rows are scaled to a largest entry of one, and stresses
/// to a compliance that is small beside it: what decides whether a pivot is taken from E, which
/// keeps the digits of E, or from c, which forms K after all.
template <class Scalar>
class MixedFactors {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  /// E: n_rows x n_c; compliance: n_rows; A: n_c x n_c. False for a matrix that is singular
  /// whatever its values.
  bool compute(const SparseMatrix& E, const Vector& compliance,
               const Eigen::SparseMatrix<Scalar>& A);
  /// Whether rounding is all that keeps the matrix from being singular.
  bool singular() const;

  /// Solves -c s + E x = e, E^T s + A x = f, refined once by what is left. e: n_rows or empty for
  /// zero; f: n_c. Writes s and x.
  void solve(const Vector& e, const Vector& f, Vector& s, Vector& x) const;

 private:
  Eigen::SparseMatrix<Scalar> matrix_;
  Eigen::SparseLU<Eigen::SparseMatrix<Scalar>, Eigen::COLAMDOrdering<int>> lu_;
  Eigen::VectorXd row_scale_, column_scale_;
  double unit_ = 1;
};

}  // namespace stillframe
