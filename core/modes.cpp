#include "core/modes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <complex>
#include <cstdio>
#include <numbers>
#include <vector>

#include "core/linear/eigenvalues.hpp"
#include "core/state_space.hpp"
#include "core/unstable.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Complex = std::complex<double>;

/// Below this part of the largest one, an eigenvalue is the rounding of a zero one, which is
/// double: about the square root of epsilon.
constexpr double zero_part = 1e-7;

/// Squares of the natural frequencies, upwards, and mass-normalised shapes.
struct Shapes {
  VectorXd squares;
  MatrixXd V;
};

/// K = L_K L_K^T: the natural frequencies themselves are the singular values of L_K^T L_M^-T, so
/// that a soft mode beside stiff ones loses epsilon omega_max and not epsilon omega_max^2.
Shapes by_singular_values(const Eigen::LLT<MatrixXd>& K, const Eigen::LLT<MatrixXd>& M) {
  const MatrixXd W_t = M.matrixL().solve(MatrixXd(K.matrixL()));
  // Jacobi's method is the more accurate one, and as fast for few dofs.
  constexpr Index few = 64;
  const auto answer = [&](const auto& svd) -> Shapes {
    const MatrixXd V = svd.matrixU().rowwise().reverse();
    return {svd.singularValues().reverse().array().square(), M.matrixU().solve(V)};
  };
  if (W_t.rows() <= few) {
    return answer(Eigen::JacobiSVD<MatrixXd>(W_t, Eigen::ComputeFullU));
  }
  return answer(Eigen::BDCSVD<MatrixXd>(W_t, Eigen::ComputeFullU));
}

Shapes natural_shapes(const LinearModel& model, const Eigen::LLT<MatrixXd>& M) {
  const MatrixXd stiffness = model.stiffness();
  const MatrixXd K = 0.5 * (stiffness + stiffness.transpose());
  const Eigen::LLT<MatrixXd> factors(K);
  if (factors.info() == Eigen::Success) return by_singular_values(factors, M);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(K, model.M);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

/// Whether nothing but rounding makes K + N + G not positive semidefinite. Scaled to a unit
/// diagonal, so that stiff elements do not hide a soft direction that has become negative; rounding
/// of n terms leaves some n epsilon.
bool is_stable(const LinearModel& model) {
  const MatrixXd stiffness = model.stiffness();
  MatrixXd K = 0.5 * (stiffness + stiffness.transpose());
  const VectorXd scale =
      K.diagonal().unaryExpr([](double k) { return k > 0 ? 1 / std::sqrt(k) : 1.0; });
  K = scale.asDiagonal() * K * scale.asDiagonal();
  if (Eigen::LLT<MatrixXd>(K).info() == Eigen::Success) return true;
  const VectorXd values =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(K, Eigen::EigenvaluesOnly).eigenvalues();
  return values(0) >= -1e-12 * values.cwiseAbs().maxCoeff();
}

/// Of the parts that are not symmetric by construction, on a unit diagonal: so that neither units
/// nor the choice of dofs have a say.
bool is_symmetric(const LinearModel& model) {
  const VectorXd scale = model.stiffness().diagonal().unaryExpr(
      [](double k) { return k != 0 ? 1 / std::sqrt(std::abs(k)) : 1.0; });
  const MatrixXd S = scale.asDiagonal() * (model.N + model.G) * scale.asDiagonal();
  const MatrixXd K = scale.asDiagonal() * model.K * scale.asDiagonal();
  return (S - S.transpose()).norm() <= 1e-9 * S.norm() + 1e-14 * K.norm();
}

/// Of an undamped model at rest: exact conjugates on the imaginary axis.
Eigen::VectorXcd imaginary_pairs(const VectorXd& squares) {
  Eigen::VectorXcd values(2 * squares.size());
  for (Index i = 0; i < squares.size(); ++i) {
    const double omega = std::sqrt(std::max(squares(i), 0.0));
    values(2 * i) = {0, omega};
    values(2 * i + 1) = {0, -omega};
  }
  return values;
}

Eigen::VectorXcd sorted_eigenvalues(const MatrixXd& A) {
  const auto found = eigenvalues(A);
  if (!found) {
    throw Refusal(
        "the eigenvalues of the state matrix cannot be computed: it is not finite, or its entries "
        "are too far apart; look for a stiffness, mass or damping with a wrong power of ten");
  }
  const Eigen::VectorXcd& values = *found;
  std::vector<Complex> real;
  std::vector<std::pair<Complex, Complex>> pairs;
  for (const Complex& value : values) {
    if (value.imag() == 0) real.push_back(value);
    if (value.imag() > 0) pairs.emplace_back(value, std::conj(value));
  }
  const auto smaller = [](const Complex& a, const Complex& b) { return std::abs(a) < std::abs(b); };
  std::stable_sort(real.begin(), real.end(), smaller);
  for (size_t i = 0; i + 1 < real.size(); i += 2) pairs.emplace_back(real[i], real[i + 1]);
  std::stable_sort(pairs.begin(), pairs.end(),
                   [&](const auto& a, const auto& b) { return smaller(a.first, b.first); });
  Eigen::VectorXcd sorted(values.size());
  Index next = 0;
  for (const auto& [one, other] : pairs) {
    sorted(next++) = one;
    sorted(next++) = other;
  }
  return sorted;
}

/// damping_ratios and n_growing from the eigenvalues.
void judge(Modes& modes) {
  const Eigen::VectorXcd& values = modes.eigenvalues;
  const double largest = values.size() ? values.cwiseAbs().maxCoeff() : 0.0;
  modes.damping_ratios.setZero(values.size() / 2);
  for (Index i = 0; i < values.size(); ++i) {
    const double modulus = std::abs(values(i)), real = values(i).real();
    if (modulus <= zero_part * largest) continue;
    double& ratio = modes.damping_ratios(i / 2);
    ratio = i % 2 == 0 ? -real / modulus : std::min(ratio, -real / modulus);
    // The rounding of an undamped one is no growth.
    if (real > std::max(1e-8 * modulus, 1e-12 * largest)) ++modes.n_growing;
  }
}

}  // namespace

Modes modes(const LinearModel& model) {
  const Eigen::LLT<MatrixXd> M = mass_factors(model);
  Modes result;
  result.moving = !model.C.isZero(0) || !model.N.isZero(0);
  bool undamped = false;
  if (is_symmetric(model)) {
    const Shapes shapes = natural_shapes(model, M);
    const bool stable = is_stable(model);
    if (!stable && !result.moving) {
      char square[32];
      std::snprintf(square, sizeof square, "%.6g", shapes.squares(0));
      throw Unstable(std::string("the configuration is not stable: omega^2 = ") + square +
                         " (rad/s)^2 in mode 1",
                     shapes.V.col(0));
    }
    if (stable) {
      result.natural_frequencies_hz =
          shapes.squares.cwiseMax(0.0).cwiseSqrt() / (2 * std::numbers::pi);
      if (!result.natural_frequencies_hz.allFinite()) {
        throw Refusal(
            "numbers of the model overflow: a natural frequency is not finite; look for a length, "
            "stiffness or mass with a wrong power of ten");
      }
      result.shapes = shapes.V;
      undamped = !result.moving && model.D.isZero(0);
      if (undamped) result.eigenvalues = imaginary_pairs(shapes.squares);
    }
  }
  if (!undamped) result.eigenvalues = sorted_eigenvalues(state_matrix(model));
  judge(result);
  return result;
}

}  // namespace stillframe
