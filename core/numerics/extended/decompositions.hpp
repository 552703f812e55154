#pragma once

#include <optional>

#include "core/numerics/extended/double_double.hpp"

// Matrix algebra in twice the working precision, for designs and their checks (set-up). Arguments
// and results are matrices of DoubleDouble unless they say otherwise.
namespace stillframe {

/// The same numbers, exactly.
inline ExtendedMatrix extended(const Eigen::MatrixXd& A) { return A.cast<DoubleDouble>(); }
/// Every entry the double nearest to it.
inline Eigen::MatrixXd rounded(const ExtendedMatrix& A) { return A.cast<double>(); }

/// L, lower triangular, L L^T = A; nothing if the symmetric A, n x n, is not positive definite.
std::optional<ExtendedMatrix> cholesky_factor(const ExtendedMatrix& A);

/// L^-1 B and L^-T B of a lower triangular L, n x n; B: n x k.
ExtendedMatrix forward_solve(const ExtendedMatrix& L, const ExtendedMatrix& B);
ExtendedMatrix backward_solve(const ExtendedMatrix& L, const ExtendedMatrix& B);

/// A^-1 B by elimination with partial pivoting; A: n x n, not singular; B: n x k.
ExtendedMatrix solve(const ExtendedMatrix& A, const ExtendedMatrix& B);

/// A = Q R, A: m x n of rank n, m >= n; Q: m x n, Q^T Q = I; R: n x n, upper triangular.
struct Orthogonalised {
  ExtendedMatrix Q, R;
};
Orthogonalised orthogonalised(const ExtendedMatrix& A);

/// A V = V diag(values), V^T V = I, of a symmetric A, n x n; values: n, smallest first.
struct SymmetricEigen {
  ExtendedVector values;
  ExtendedMatrix V;
};
SymmetricEigen symmetric_eigen(const ExtendedMatrix& A);

/// The n eigenvalues of A, n x n, rounded, smallest modulus first, conjugates side by side. Errors:
/// std::runtime_error if the QR iterations do not converge.
Eigen::VectorXcd eigenvalues(const ExtendedMatrix& A);

}  // namespace stillframe
