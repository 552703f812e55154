#pragma once

#include <Eigen/SparseCore>
#include <functional>

namespace stillframe {

/// y = T x, both of length n.
using LinearMap = std::function<void(const Eigen::VectorXd& x, Eigen::VectorXd& y)>;

/// Eigenvalues of largest modulus or, algebraically, the largest ones.
enum class Largest { modulus, algebraic };

/// Of A v = theta S v.
struct LanczosPairs {
  Eigen::VectorXd values;   ///< n_pairs or fewer, largest first
  Eigen::MatrixXd vectors;  ///< n x as many
  bool converged = false;   ///< all that were asked for, or as many as there are
};

/// The n_pairs largest of A v = theta S v, or as many as there are that are not zero, multiple ones
/// as often as they are multiple. A: n x n, symmetric; solve: S^-1, of a symmetric S. S: as a map,
/// which has to be positive definite, and S-normalised are the vectors then; without it A has to be
/// positive semidefinite, and A-normalised are they. By implicitly restarted Lanczos; where A is on
/// few coordinates by a dense matrix of those, and in_any_time on up to 3000 where Lanczos' method
/// does not converge.
LanczosPairs largest_pairs(const Eigen::SparseMatrix<double>& A, Eigen::Index n_pairs,
                           Largest order, const LinearMap& solve, const LinearMap& S = {},
                           bool in_any_time = false);

}  // namespace stillframe
