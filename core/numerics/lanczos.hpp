#pragma once

#include <Eigen/SparseCore>
#include <functional>

namespace stillframe {

/// y = T x, both of length n.
using LinearMap = std::function<void(const Eigen::VectorXd& x, Eigen::VectorXd& y)>;

enum class Largest { modulus, algebraic };

/// Eigenvalues of A v = theta S v, best first, and their vectors (n x n_pairs).
struct LanczosPairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
  bool converged = false;
};

/// The n_pairs largest of A v = theta S v, or as many as there are that are not zero, multiple ones
/// as often as they are multiple. A: n x n, symmetric; solve: S^-1, of a symmetric S. S: as a map,
/// which has to be positive definite, and S-normalised are the vectors then; without it A has to be
/// positive semidefinite, and A-normalised are they. By implicitly restarted Lanczos; where A is on
/// few coordinates by a dense matrix of those.
LanczosPairs largest_pairs(const Eigen::SparseMatrix<double>& A, Eigen::Index n_pairs,
                           Largest order, const LinearMap& solve, const LinearMap& S = {});

}  // namespace stillframe
