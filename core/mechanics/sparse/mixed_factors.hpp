#pragma once

#include <Eigen/SparseCholesky>
#include <type_traits>
#include <vector>

#include "core/mechanics/sparse/mixed_model.hpp"

namespace stillframe {

/// Solves the mixed form [-c, E; E^T, A] of a sparse model by factors L D L^T of
/// E^T (c + d)^-1 E + A, where d is small and stands for the compliance of what has none, and by
/// refinement: what is left over is that of the mixed form, so that neither d nor the rounding of
/// the stiffness matrix is in the solution. Where rounding of the matrix is more than refinement
/// makes up for, the factors are those of long double. What depends on E and on the pattern alone
/// is kept from one compute to the next.
template <class Scalar>
class MixedFactors {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  /// E: n_rows x n_c; compliance: n_rows; A: n_c x n_c, symmetric. False if the matrix is singular,
  /// or not to be told from one that is.
  bool compute(const SparseMatrix& E, const Vector& compliance,
               const Eigen::SparseMatrix<Scalar>& A);

  /// The negative eigenvalues of the stiffness matrix that was last factorised, by Sylvester's law.
  Eigen::Index n_negative() const requires std::is_same_v<Scalar, double> {
    return in_long_double_ ? (long_double_.of.vectorD().array() < 0).count()
                           : (double_.of.vectorD().array() < 0).count();
  }

  /// Solves -c s + E x = e, E^T s + A x = f. e: n_rows or empty for zero; f: n_c. Writes s and x.
  void solve(const Vector& e, const Vector& f, Vector& s, Vector& x) const;

 private:
  /// What a solution has come to.
  struct Refined {
    double rate = 0;    ///< by how much a step is shorter than the one before
    bool done = false;  ///< to rounding
  };
  template <class Real>
  struct Factors {
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<Real>> of;
    std::vector<int> starts, rows;  ///< the pattern that was analysed
  };

  void take_rows(const SparseMatrix& E, const Vector& compliance);
  template <class Real>
  bool factorise(Factors<Real>& factors) const;
  template <class Real>
  static Vector solved(const Factors<Real>& factors, const Vector& right);
  Vector step(const Vector& right) const;
  Refined refine(const Vector& e, const Vector& f, Vector& s, Vector& x) const;

  SparseMatrix E_;
  Eigen::SparseMatrix<Scalar> A_;
  Vector compliance_, stiffness_;
  bool independent_ = false;  ///< the rows of E_ without compliance
  Factors<double> double_;
  Factors<long double> long_double_;
  bool in_long_double_ = false;
};

}  // namespace stillframe
