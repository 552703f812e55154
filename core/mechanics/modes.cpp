#include "core/mechanics/modes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <complex>

#include "core/errors/formatted.hpp"
#include "core/mechanics/force_balance.hpp"
#include "core/mechanics/own_values.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/mechanics/unstable.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Complex = std::complex<double>;

/// As NaturalShapes, without what they are known to.
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

Shapes shapes_of(const LinearModel& model, const Eigen::LLT<MatrixXd>& M) {
  const MatrixXd stiffness = model.stiffness();
  const MatrixXd K = 0.5 * (stiffness + stiffness.transpose());
  Eigen::LLT<MatrixXd> factors(K);
  if (factors.info() == Eigen::Success) return by_singular_values(factors, M);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(K, model.M);
  const Shapes direct{solver.eigenvalues(), solver.eigenvectors()};
  const double noise = 1e-14 * static_cast<double>(K.rows()) * direct.squares.cwiseAbs().maxCoeff();
  const auto elastic = std::find_if(direct.squares.begin(), direct.squares.end(),
                                    [&](double square) { return square > noise; });
  if (direct.squares(0) < -noise || elastic == direct.squares.end()) return direct;
  // Only what moves freely: from a shift below the others, so that these and the slow ones lose
  // epsilon omega_max as well.
  const double shift = 0.1 * *elastic;
  factors.compute(K + shift * model.M);
  if (factors.info() != Eigen::Success) return direct;
  Shapes shapes = by_singular_values(factors, M);
  for (Index i = 0; i < K.rows(); ++i) {
    const bool free = shapes.squares(i) < 2 * shift;
    shapes.squares(i) = free ? shapes.V.col(i).dot(K * shapes.V.col(i)) : shapes.squares(i) - shift;
  }
  return shapes;
}

bool is_stable(const LinearModel& model) { return n_negative(model.stiffness()) == 0; }

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

/// What natural frequencies are known to, rad/s, from the shapes: without damping and gyroscopy
/// those are the eigenvectors.
VectorXd known_to(const LinearModel& model, const Shapes& shapes) {
  LinearModel undamped = model;
  undamped.C.setZero();
  undamped.D.setZero();
  const EigenvalueRounding rounding(undamped);
  VectorXd known(shapes.squares.size());
  for (Index i = 0; i < known.size(); ++i) {
    const Eigen::VectorXcd v = shapes.V.col(i).cast<Complex>();
    known(i) = rounding.known_to({0, std::sqrt(std::max(shapes.squares(i), 0.0))}, v, v);
  }
  return known;
}

}  // namespace

void judge_eigenvalues(Modes& modes) {
  Eigen::VectorXcd& values = modes.eigenvalues;
  modes.damping_ratios.setZero(values.size() / 2);
  for (Index i = 0; i < values.size(); ++i) {
    const double modulus = std::abs(values(i)), real = values(i).real();
    if (modulus <= modes.known_to(i)) {
      values(i) = 0;
      continue;
    }
    double& ratio = modes.damping_ratios(i / 2);
    ratio = i % 2 == 0 ? -real / modulus : std::min(ratio, -real / modulus);
    // Nor is it growth what the position is off by: forces balance to some 1e-9 of the largest.
    // A pinned chain of 40 beams was off by 1.7 times what a double root is known to.
    if (real > std::max(1e-8 * modulus, 4 * modes.known_to(i))) ++modes.n_growing;
  }
}

NaturalShapes natural_shapes(const LinearModel& model) {
  const Shapes shapes = shapes_of(model, mass_factors(model));
  return {shapes.squares, shapes.V, known_to(model, shapes)};
}

Modes modes(const LinearModel& model) {
  const Eigen::LLT<MatrixXd> M = mass_factors(model);
  Modes result;
  result.moving = !model.C.isZero(0) || !model.N.isZero(0);
  bool undamped = false;
  if (is_symmetric(model)) {
    const Shapes shapes = shapes_of(model, M);
    const bool stable = is_stable(model);
    if (!stable && !result.moving) {
      throw Unstable(formatted("omega^2 = %.6g (rad/s)^2 in mode 1", shapes.squares(0)),
                     shapes.V.col(0));
    }
    if (stable) {
      const VectorXd omega = shapes.squares.cwiseMax(0.0).cwiseSqrt(),
                     known = known_to(model, shapes);
      if (!omega.allFinite() || !known.allFinite()) {
        throw Refusal(
            "numbers of the model overflow: a natural frequency is not finite; look for a length, "
            "stiffness or mass with a wrong power of ten");
      }
      result.natural_frequencies_hz = (omega.array() > known.array()).select(omega, 0) / two_pi;
      result.shapes = shapes.V;
      undamped = !result.moving && model.D.isZero(0);
      if (undamped) {
        result.eigenvalues = imaginary_pairs(shapes.squares);
        result.known_to = known.replicate(1, 2).transpose().reshaped();
      }
    }
  }
  if (!undamped) {
    const OwnValues own = own_values(model);
    result.eigenvalues = own.values;
    result.known_to = own.known_to;
  }
  judge_eigenvalues(result);
  return result;
}

Stability stability(const LinearModel& model) {
  const bool at_rest = model.C.isZero(0) && model.N.isZero(0);
  const bool by_stiffness = at_rest && is_symmetric(model);
  // Dampers take energy, and so change nothing about which stiffness is stable.
  if (by_stiffness && is_stable(model)) return {true, "", {}};
  try {
    const Modes found = modes(model);
    if (found.n_growing == 0) return {true, "", {}};
    return {
        false, std::to_string(found.n_growing) + " eigenvalue(s) with a positive real part", {}};
  } catch (const Unstable& error) {
    return {false, error.why(), error.shape()};
  } catch (const Refusal&) {
    if (by_stiffness) return {false, "the stiffness is not positive definite", {}};
    return {};
  }
}

}  // namespace stillframe
