#pragma once

#include <Eigen/Core>
#include <functional>

namespace stillframe {

/// y = A x of a symmetric A, both n.
using LinearMap = std::function<void(const Eigen::VectorXd& x, Eigen::VectorXd& y)>;

/// Eigenvalues of largest modulus or, algebraically, the largest ones.
enum class Largest { modulus, algebraic };

struct LanczosPairs {
  Eigen::VectorXd values;   ///< n_pairs, largest first
  Eigen::MatrixXd vectors;  ///< n x n_pairs, V^T B V = I
  bool converged = false;   ///< all that were asked for, or as many as there are
};

/// The n_pairs largest eigenvalues of T, which is self-adjoint in the inner product of B (positive
/// semidefinite, and definite where T maps to), by the implicitly restarted Lanczos method of
/// Spectra. A Krylov space sees one vector of an eigenvalue that repeats, and others by rounding
/// alone: what was found is taken away and looked for again, until nothing larger than the last is
/// left. n, n_pairs < n.
LanczosPairs largest_pairs(Eigen::Index n, Eigen::Index n_pairs, Largest order, const LinearMap& T,
                           const LinearMap& B);

}  // namespace stillframe
