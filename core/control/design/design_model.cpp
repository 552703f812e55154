#include "core/control/design/design_model.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/extended/decompositions.hpp"
#include "core/numerics/positive_definite.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Below this part of the largest, a singular value of E is the rounding of a zero: E comes with
/// errors of some eps, a few hundred at most.
constexpr double zero_part = 1e-12;

ExtendedMatrix symmetric(const ExtendedMatrix& A) {
  return (A + A.transpose()) * DoubleDouble(0.5);
}

/// "a", "a and b", "a, b and c".
std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (size_t i = 0; i < words.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
  }
  return text;
}

/// The names of the entries of a vector that are not small beside its largest.
std::string leading(const VectorXd& v, const std::vector<std::string>& names,
                    const std::string& kind) {
  std::vector<std::string> found;
  for (Index i = 0; i < v.size(); ++i) {
    if (std::abs(v(i)) < 0.1 * v.cwiseAbs().maxCoeff()) continue;
    const size_t k = static_cast<size_t>(i);
    found.push_back(k < names.size() ? names[k] : kind + " " + std::to_string(i + 1));
  }
  return listed(found);
}

/// The frame in mass-normalised coordinates p = L^T q, M_dd = L L^T, in which all motions count
/// alike whatever the dofs and their units: kinetic energy p'^T p' / 2.
struct Frame {
  ExtendedMatrix L, K, E;  ///< n_d x n_d; K: n_d x n_d, 1/s^2; E: m x n_d, 1/sqrt(kg)
};

Frame normalised(const MatrixXd& M_dd, const MatrixXd& K_dd, const MatrixXd& E) {
  const ExtendedMatrix L = mass_factor(M_dd);
  const ExtendedMatrix half = forward_solve(L, extended(K_dd));
  return {.L = L,
          .K = symmetric(forward_solve(L, half.transpose())),
          .E = forward_solve(L, extended(E).transpose()).transpose()};
}

/// The dofs that hold much of the kinetic energy of a motion p.
std::string moved_most(const Frame& frame, const VectorXd& p, const DesignNames& names) {
  const VectorXd q = rounded(backward_solve(frame.L, extended(p)));
  // Rows of L are as long as the roots of the diagonal of M_dd.
  return leading(q.cwiseProduct(rounded(frame.L).rowwise().norm()), names.dofs, "dof");
}

[[noreturn]] void refuse_dependent(const VectorXd& elongations, const DesignNames& names) {
  throw Refusal("the elongations of " + leading(elongations, names.legs, "leg") +
                " depend on each other: no motion of the frame moves these legs one by one; leave "
                "one of them out of the loop, where it stays as a spring, or stand the frame on as "
                "many as can move alone (docs/design.md)");
}

void require_full_rank(const Frame& frame, const DesignNames& names) {
  const Eigen::JacobiSVD<MatrixXd> svd(rounded(frame.E), Eigen::ComputeFullU | Eigen::ComputeFullV);
  const VectorXd& values = svd.singularValues();
  const Index m = frame.E.rows(), n = frame.E.cols(), r = values.size();
  if (values(r - 1) > zero_part * values(0)) return;
  const Index rank = (values.array() > zero_part * values(0)).count();
  if (m < n) refuse_dependent(svd.matrixU().col(r - 1), names);
  std::string way_out = "take legs that strain it";
  if (rank > 0) {
    way_out += ", or leave " + std::to_string(m - rank) + " of the " + std::to_string(m) +
               " legs out of the loop, so that each of the others can move alone";
  }
  throw Refusal("the legs do not determine the motion of the frame: a motion of " +
                moved_most(frame, svd.matrixV().col(n - 1), names) + " strains none of them; " +
                way_out);
}

/// q = E^-1 e: elongations of as many legs as dofs.
LegMatrices square(const Frame& frame) {
  const Index m = frame.E.rows();
  const ExtendedMatrix inverse = solve(frame.E, ExtendedMatrix::Identity(m, m));
  return {.M = rounded(symmetric(inverse.transpose() * inverse)),
          .K = rounded(symmetric(inverse.transpose() * frame.K * inverse))};
}

DesignModel redundant(const Frame& frame) {
  // In combined elongations Q^T e the legs are as many as the dofs: E = Q R.
  const auto [Q, R] = orthogonalised(frame.E);
  return {.legs = square({.L = frame.L, .K = frame.K, .E = R}), .Q = rounded(Q)};
}

std::string mode_name(Index mode, double square) {
  return formatted("%td (%.6g Hz)", mode + 1, std::sqrt(std::max(square, 0.0)) / two_pi);
}

LegMatrices on_slowest_modes(const Frame& frame, const DesignNames& names) {
  const Index m = frame.E.rows();
  const SymmetricEigen modes = symmetric_eigen(frame.K);
  const VectorXd squares = modes.values.cast<double>();
  if (squares(m) - squares(m - 1) <= 2 * same_frequency * std::abs(squares(m))) {
    throw Refusal(std::to_string(m) + " legs cannot tell mode " + mode_name(m - 1, squares(m - 1)) +
                  " from mode " + mode_name(m, squares(m)) +
                  ", which are of one frequency: take one leg more or fewer, or reduce by "
                  "static_shapes");
  }
  const ExtendedMatrix E_r = frame.E * modes.V.leftCols(m);
  const Eigen::JacobiSVD<MatrixXd> svd(rounded(E_r), Eigen::ComputeFullV);
  if (!(svd.singularValues()(m - 1) > zero_part * svd.singularValues()(0))) {
    // No frequency: what moves against weight and preload alone has none in K.
    const VectorXd v = svd.matrixV().col(m - 1);
    const bool stiff = v.cwiseAbs2().dot(squares.head(m)) > zero_part * squares(squares.size() - 1);
    throw Refusal(
        "the slowest modes cannot be controlled by these legs: a motion of " +
        moved_most(frame, rounded(modes.V.leftCols(m)) * v, names) +
        " strains none of them; take other legs, or " +
        (stiff ? "reduce by static_shapes" : "give it a spring and reduce by static_shapes"));
  }
  const ExtendedMatrix inverse = solve(E_r, ExtendedMatrix::Identity(m, m));
  return {
      .M = rounded(symmetric(inverse.transpose() * inverse)),
      .K = rounded(symmetric(inverse.transpose() * modes.values.head(m).asDiagonal() * inverse))};
}

LegMatrices on_static_shapes(const Frame& frame, const DesignNames& names) {
  try {
    require_stiffness(rounded(frame.K));
  } catch (const Refusal& refusal) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(rounded(frame.K));
    throw Refusal(std::string(refusal.what()) + "; such a motion is one of " +
                  moved_most(frame, modes.eigenvectors().col(0), names) +
                  ": give it a spring, as weight and preload do not count");
  }
  const ExtendedMatrix L = cholesky_factor(frame.K).value();
  const Index m = frame.E.rows();
  const ExtendedMatrix W = forward_solve(L, frame.E.transpose());
  const ExtendedMatrix F = W.transpose() * W;  // static compliance of the legs
  const ExtendedMatrix K = symmetric(solve(F, ExtendedMatrix::Identity(m, m)));
  try {
    require_stiffness(rounded(K));
  } catch (const Refusal&) {
    // All motions have stiffness: what has none to rounding is an elongation that there hardly is,
    // as where the weight bends what would depend on each other by a hair.
    const Eigen::JacobiSVD<MatrixXd> svd(rounded(frame.E), Eigen::ComputeFullU);
    refuse_dependent(svd.matrixU().col(m - 1), names);
  }
  const ExtendedMatrix shapes = backward_solve(L, W) * K;
  return {.M = rounded(symmetric(shapes.transpose() * shapes)), .K = rounded(K)};
}

void require_shapes(const MatrixXd& M, const MatrixXd& K, const MatrixXd& E) {
  const Index n = M.rows();
  if (n < 1 || M.cols() != n || K.rows() != n || K.cols() != n || E.cols() != n || E.rows() < 1) {
    throw std::invalid_argument(
        "design_model: expected M and K of n x n and E of m x n, n and m at "
        "least 1, got E of " +
        std::to_string(E.rows()) + " x " + std::to_string(E.cols()) + " with M of " +
        std::to_string(n) + " rows");
  }
}

}  // namespace

DesignModel design_model(const MatrixXd& M_dd, const MatrixXd& K_dd, const MatrixXd& E,
                         Reduction reduction, const DesignNames& names) {
  require_shapes(M_dd, K_dd, E);
  const Index m = E.rows(), n = E.cols();
  const MatrixXd I = MatrixXd::Identity(m, m);
  const Frame frame = normalised(M_dd, K_dd, E);
  require_full_rank(frame, names);
  if (m > n) return redundant(frame);
  if (m == n) return {.legs = square(frame), .Q = I};
  return {.legs = reduction == Reduction::modes ? on_slowest_modes(frame, names)
                                                : on_static_shapes(frame, names),
          .Q = I};
}

LegMatrices leg_matrices(const MatrixXd& M_dd, const MatrixXd& K_dd, const MatrixXd& E) {
  if (E.rows() != E.cols()) {
    throw Refusal("leg coordinates need as many legs as dofs: " + std::to_string(E.rows()) +
                  " legs, " + std::to_string(E.cols()) + " dofs");
  }
  return design_model(M_dd, K_dd, E).legs;
}

}  // namespace stillframe
