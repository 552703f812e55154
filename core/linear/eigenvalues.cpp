#include "core/linear/eigenvalues.hpp"

#include <Eigen/Eigenvalues>
#include <limits>

#include "core/linear/balance.hpp"

namespace stillframe {

namespace {

template <typename Solver, typename Matrix>
std::optional<Eigen::VectorXcd> found_by(const Matrix& A) {
  if (A.rows() == 0) return Eigen::VectorXcd(0);
  if (!A.allFinite()) return std::nullopt;
  const Solver solver(A, false);
  if (solver.info() != Eigen::Success || !solver.eigenvalues().allFinite()) return std::nullopt;
  return solver.eigenvalues();
}

}  // namespace

std::optional<Eigen::VectorXcd> eigenvalues(const Eigen::MatrixXd& A) {
  if (!A.allFinite()) return std::nullopt;  // balancing asks for an order of the entries
  return found_by<Eigen::EigenSolver<Eigen::MatrixXd>>(balanced(A));
}

std::optional<Eigen::VectorXcd> eigenvalues(const Eigen::MatrixXcd& A) {
  return found_by<Eigen::ComplexEigenSolver<Eigen::MatrixXcd>>(A);
}

double spectral_radius(const Eigen::MatrixXd& A) {
  const auto values = eigenvalues(A);
  if (!values) return std::numeric_limits<double>::infinity();
  return values->size() > 0 ? values->cwiseAbs().maxCoeff() : 0.0;
}

}  // namespace stillframe
