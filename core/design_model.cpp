#include "core/design_model.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

#include "core/extended/decompositions.hpp"
#include "core/positive_definite.hpp"
#include "core/yaml/input_error.hpp"

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

void require_full_rank(const Frame& frame, const MatrixXd& M_dd, const DesignNames& names) {
  const Eigen::JacobiSVD<MatrixXd> svd(rounded(frame.E), Eigen::ComputeFullU | Eigen::ComputeFullV);
  const VectorXd& values = svd.singularValues();
  const Index m = frame.E.rows(), n = frame.E.cols(), r = values.size();
  if (values(r - 1) > zero_part * values(0)) return;
  if (m < n) {
    throw Refusal("the elongations of " + leading(svd.matrixU().col(r - 1), names.legs, "leg") +
                  " depend on each other: no motion of the frame moves these legs one by one");
  }
  const ExtendedMatrix v = extended(svd.matrixV().col(n - 1));
  // Of the dofs of a motion, those name it that hold much of its kinetic energy.
  const VectorXd motion =
      rounded(backward_solve(frame.L, v)).cwiseProduct(M_dd.diagonal().cwiseSqrt());
  throw Refusal("the legs do not determine the motion of the frame: a motion of " +
                leading(motion, names.dofs, "dof") + " strains none of them");
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
  char text[64];
  std::snprintf(text, sizeof text, "%td (%.6g Hz)", mode + 1,
                std::sqrt(std::max(square, 0.0)) / (2 * std::numbers::pi));
  return text;
}

LegMatrices on_slowest_modes(const Frame& frame) {
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
    std::vector<std::string> names;
    for (Index i = 0; i < m; ++i) names.push_back(mode_name(i, squares(i)));
    const std::string motion = leading(svd.matrixV().col(m - 1), names, "");
    throw Refusal("the slowest modes cannot be controlled by these legs: a motion of mode" +
                  std::string(motion.find(" and ") == std::string::npos ? " " : "s ") + motion +
                  " strains none of them; take other legs, or reduce by static_shapes");
  }
  const ExtendedMatrix inverse = solve(E_r, ExtendedMatrix::Identity(m, m));
  return {
      .M = rounded(symmetric(inverse.transpose() * inverse)),
      .K = rounded(symmetric(inverse.transpose() * modes.values.head(m).asDiagonal() * inverse))};
}

LegMatrices on_static_shapes(const Frame& frame) {
  require_stiffness(rounded(frame.K));
  const ExtendedMatrix L = cholesky_factor(frame.K).value();
  const Index m = frame.E.rows();
  const ExtendedMatrix W = forward_solve(L, frame.E.transpose());
  const ExtendedMatrix F = W.transpose() * W;  // static compliance of the legs
  const ExtendedMatrix K = symmetric(solve(F, ExtendedMatrix::Identity(m, m)));
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
  require_full_rank(frame, M_dd, names);
  if (m > n) return redundant(frame);
  if (m == n) return {.legs = square(frame), .Q = I};
  return {.legs = reduction == Reduction::modes ? on_slowest_modes(frame) : on_static_shapes(frame),
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
