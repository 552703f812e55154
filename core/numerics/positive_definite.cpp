#include "core/numerics/positive_definite.hpp"

#include <Eigen/Eigenvalues>
#include <limits>
#include <optional>

#include "core/errors/input_error.hpp"
#include "core/numerics/extended/decompositions.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::optional<ExtendedMatrix> factor(const MatrixXd& A) {
  if (!A.allFinite() || !(A.diagonal().minCoeff() > 0)) return std::nullopt;
  const VectorXd scale = A.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = scale.asDiagonal() * A * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(scaled, Eigen::EigenvaluesOnly);
  // The entries are sums of products themselves, each with some roundings.
  const double rounding =
      10 * static_cast<double>(A.rows()) * std::numeric_limits<double>::epsilon();
  if (!(solver.eigenvalues()(0) > rounding)) return std::nullopt;
  return cholesky_factor(extended(A));
}

}  // namespace

ExtendedMatrix mass_factor(const MatrixXd& M) {
  if (auto L = factor(M)) return *L;
  throw Refusal("the mass matrix is not positive definite: the legs move a dof without mass");
}

void require_stiffness(const MatrixXd& K) {
  if (factor(K)) return;
  throw Refusal(
      "the stiffness matrix is not positive definite: a motion without stiffness makes no force "
      "that could be fed back");
}

}  // namespace stillframe
