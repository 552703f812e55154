#pragma once

#include <Eigen/Core>
#include <optional>

namespace stillframe {

/// All eigenvalues of a matrix that need not be symmetric (n x n; a real one is balanced first), or
/// nothing where an entry or an eigenvalue is not finite or the iteration does not end: Eigen's own
/// answer is then whatever stood in memory. Every judgement of a loop comes through here. Set-up.
std::optional<Eigen::VectorXcd> eigenvalues(const Eigen::MatrixXd& A);
std::optional<Eigen::VectorXcd> eigenvalues(const Eigen::MatrixXcd& A);

/// Their largest modulus, 0 of an empty matrix. Infinite where they are not known, so that no
/// comparison with a bound takes such a matrix for a stable one, whichever way it is written.
double spectral_radius(const Eigen::MatrixXd& A);

/// A = Q T Q^T of a real matrix, T quasi-triangular and Q orthogonal (n x n), or nothing where it
/// is not found. Set-up.
struct RealSchurForm {
  Eigen::MatrixXd T, Q;
};
std::optional<RealSchurForm> real_schur_form(const Eigen::MatrixXd& A);

}  // namespace stillframe
