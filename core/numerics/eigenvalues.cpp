#include "core/numerics/eigenvalues.hpp"

#include <Eigen/Eigenvalues>

#include "core/numerics/balance.hpp"
#include "core/numerics/infinity.hpp"

namespace stillframe {

using Eigen::MatrixXd;

namespace {

template <typename Solver, typename Matrix>
std::optional<Eigen::VectorXcd> found_by(const Matrix& A) {
  if (A.rows() == 0) return Eigen::VectorXcd(0);
  if (!A.allFinite()) return std::nullopt;
  const Solver solver(A, false);
  if (solver.info() != Eigen::Success || !solver.eigenvalues().allFinite()) return std::nullopt;
  return solver.eigenvalues();
}

/// The reflection I - 2 v v^T along a direction that is none of a model. Eigen's QR iteration of a
/// matrix with a part that is orthogonal but for 1e-10 or so (equal modes at 1 rad/s that hardly
/// couple) goes round without end; that of the same matrix reflected does not.
MatrixXd reflection(Eigen::Index n) {
  Eigen::VectorXd v(n);
  for (Eigen::Index i = 0; i < n; ++i) v(i) = 1 + 0.37 * static_cast<double>(i);
  v.normalize();
  return MatrixXd::Identity(n, n) - 2 * v * v.transpose();
}

}  // namespace

std::optional<Eigen::VectorXcd> eigenvalues(const MatrixXd& A) {
  if (!A.allFinite()) return std::nullopt;  // balancing asks for an order of the entries
  using Solver = Eigen::EigenSolver<MatrixXd>;
  const MatrixXd scaled = balanced(A);
  const auto found = found_by<Solver>(scaled);
  if (found) return found;
  const MatrixXd H = reflection(A.rows());
  auto again = found_by<Solver>(MatrixXd(H * scaled * H));
  // Now known to some epsilon of the norm; where that is far more than any of them, not at all.
  if (again && !(scaled.norm() <= 100 * again->cwiseAbs().maxCoeff())) again.reset();
  return again;
}

std::optional<Eigen::VectorXcd> eigenvalues(const Eigen::MatrixXcd& A) {
  return found_by<Eigen::ComplexEigenSolver<Eigen::MatrixXcd>>(A);
}

std::optional<RealSchurForm> real_schur_form(const MatrixXd& A) {
  if (A.rows() == 0) return RealSchurForm{A, A};
  if (!A.allFinite()) return std::nullopt;
  const auto form = [](const MatrixXd& of) -> std::optional<RealSchurForm> {
    const Eigen::RealSchur<MatrixXd> schur(of);
    if (schur.info() != Eigen::Success || !schur.matrixT().allFinite()) return std::nullopt;
    return RealSchurForm{schur.matrixT(), schur.matrixU()};
  };
  auto found = form(A);
  if (found) return found;
  const MatrixXd H = reflection(A.rows());
  found = form(H * A * H);
  if (found) found->Q = H * found->Q;
  return found;
}

double spectral_radius(const MatrixXd& A) {
  const auto values = eigenvalues(A);
  if (!values) return infinity;
  return values->size() > 0 ? values->cwiseAbs().maxCoeff() : 0.0;
}

}  // namespace stillframe
