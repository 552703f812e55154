#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "core/control/h2_law.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/riccati.hpp"
#include "core/numerics/stein.hpp"

namespace stillframe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double low, double high) { return low + (high - low) * engine_() / 4294967296.0; }
  Index size(Index low, Index high) {
    return low + static_cast<Index>(engine_() % static_cast<unsigned>(high - low + 1));
  }
  MatrixXd matrix(Index rows, Index columns) {
    return MatrixXd::NullaryExpr(rows, columns, [&] { return between(-1, 1); });
  }

 private:
  std::mt19937 engine_;
};

MatrixXd square(const MatrixXd& F) { return F.transpose() * F; }

/// Unstable as well as stable ones, with a cross term, the whole cost positive.
RiccatiProblem random_problem(Random& draw) {
  const Index n = draw.size(1, 12), m = draw.size(1, 4);
  const MatrixXd cost = draw.matrix(n + m + 1, n + m);
  const MatrixXd W = square(cost);
  return {.A = draw.between(0.3, 1.5) * draw.matrix(n, n),
          .B = draw.matrix(n, m),
          .Q = W.topLeftCorner(n, n),
          .R = W.bottomRightCorner(m, m) + 1e-3 * MatrixXd::Identity(m, m),
          .S = W.topRightCorner(n, m)};
}

TEST(Riccati, LeavesNoResidualAndStabilises) {
  Random draw(1);
  for (int i = 0; i < 200; ++i) {
    const RiccatiProblem p = random_problem(draw);
    const RiccatiSolution found = solve_riccati(p);
    // Rounding of products of up to 12 terms, some of them larger than their sum.
    EXPECT_LT(found.residual, 1e-12) << i;
    EXPECT_LT(spectral_radius(MatrixXd(p.A - p.B * found.K)), 1) << i;
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<MatrixXd>(found.X).eigenvalues().minCoeff(),
              -1e-9 * found.X.norm());
  }
}

TEST(Riccati, IsTheCostOfItsOwnLaw) {
  // Another way to X: the cost of u = -K x as a sum, which any other K makes dearer.
  Random draw(2);
  for (int i = 0; i < 50; ++i) {
    const RiccatiProblem p = random_problem(draw);
    const RiccatiSolution found = solve_riccati(p);
    const auto cost = [&](const MatrixXd& K) -> MatrixXd {
      const MatrixXd W = p.Q - p.S * K - K.transpose() * p.S.transpose() + K.transpose() * p.R * K;
      return solve_stein(p.A - p.B * K, W);
    };
    // Rounding of a term is as large in the sum as all that comes of it: up to 1e9 here, where one
    // input holds nine unstable modes. Ten of it were seen.
    const MatrixXd I = MatrixXd::Identity(p.A.rows(), p.A.rows());
    const double reach = solve_stein(p.A - p.B * found.K, I).norm();
    EXPECT_LT((cost(found.K) - found.X).norm(), 1e-14 * (1 + reach) * found.X.norm()) << i;
    const MatrixXd other = found.K + 1e-3 * draw.matrix(found.K.rows(), found.K.cols());
    if (!(spectral_radius(MatrixXd(p.A - p.B * other)) < 1)) continue;
    EXPECT_GT((cost(other) - found.X).trace(), 0) << i;
  }
}

TEST(Riccati, OfOneNumberIsARootOfItsQuadratic) {
  // x = a^2 x - a^2 b^2 x^2 / (r + b^2 x) + q.
  for (const double a : {0.0, 0.5, 1.0, -1.0, 3.0}) {
    const double b = 0.7, q = 2, r = 0.3;
    const double half = (q * b * b + r * (a * a - 1)) / 2;
    const double x = (half + std::sqrt(half * half + b * b * q * r)) / (b * b);
    const auto one = [](double value) { return MatrixXd::Constant(1, 1, value); };
    const auto found = solve_riccati({.A = one(a), .B = one(b), .Q = one(q), .R = one(r)});
    EXPECT_NEAR(found.X(0, 0), x, 1e-13 * x) << a;
  }
}

/// Undamped oscillators, sampled more and more finely: poles on the unit circle, ever nearer to 1.
TEST(Riccati, TakesUndampedModesAtSmallSteps) {
  for (const double angle : {1.0, 1e-2, 1e-4, 1e-6}) {
    MatrixXd A(2, 2), B(2, 1);
    A << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
    B << 1 - std::cos(angle), std::sin(angle);
    const auto found = solve_riccati(
        {.A = A, .B = B, .Q = MatrixXd::Identity(2, 2), .R = MatrixXd::Identity(1, 1)});
    EXPECT_LT(found.residual, 1e-13) << angle;
    EXPECT_LT(found.radius, 1) << angle;
  }
}

/// A mode on the circle that the input hardly reaches decays hardly, and is stabilised all the
/// same.
TEST(Riccati, TakesWeaklyControllableModes) {
  for (const double reach : {1e-2, 1e-4, 1e-6}) {
    MatrixXd A = MatrixXd::Identity(2, 2), B(2, 1);
    A(0, 0) = 0.5;
    B << 1, reach;
    const auto found = solve_riccati(
        {.A = A, .B = B, .Q = MatrixXd::Identity(2, 2), .R = MatrixXd::Identity(1, 1)});
    EXPECT_LT(found.residual, 1e-12) << reach;
    // An integrator at unit cost closes at 1 - reach to first order, less what the other takes.
    EXPECT_LT(found.radius, 1 - 0.1 * reach) << reach;
  }
}

TEST(Riccati, DoesNotDependOnUnits) {
  Random draw(3);
  for (int i = 0; i < 50; ++i) {
    const RiccatiProblem p = random_problem(draw);
    const Index n = p.A.rows(), m = p.B.cols();
    const auto decades = [&](Index size) -> Eigen::VectorXd {
      return Eigen::VectorXd::NullaryExpr(size, [&] { return std::pow(10, draw.between(-8, 8)); });
    };
    const Eigen::VectorXd x = decades(n), u = decades(m);
    const MatrixXd D = x.asDiagonal(), D_1 = x.cwiseInverse().asDiagonal(), U = u.asDiagonal();
    const auto same =
        solve_riccati({D_1 * p.A * D, D_1 * p.B * U, D * p.Q * D, U * p.R * U, D * p.S * U});
    const auto found = solve_riccati(p);
    const MatrixXd X = D_1 * same.X * D_1;
    EXPECT_LT((X - found.X).norm(), 1e-8 * found.X.norm()) << i;
  }
}

TEST(Riccati, RefusesWhatHasNoSolution) {
  const MatrixXd I = MatrixXd::Identity(2, 2);
  MatrixXd singular(2, 2);
  singular << 1, 1, 1, 1;
  EXPECT_THROW(solve_riccati({.A = I, .B = I, .Q = I, .R = singular}), Refusal);
  EXPECT_THROW(solve_riccati({.A = I, .B = I, .Q = I, .R = MatrixXd::Zero(2, 2)}), Refusal);
  // Not controllable and unstable; on the circle and without cost.
  EXPECT_THROW(solve_riccati({.A = 2 * I, .B = MatrixXd::Zero(2, 2), .Q = I, .R = I}), Refusal);
  EXPECT_THROW(solve_riccati({.A = I, .B = MatrixXd::Zero(2, 2), .Q = I, .R = I}), Refusal);
  EXPECT_THROW(solve_riccati({.A = I, .B = I, .Q = I, .R = MatrixXd::Identity(1, 1)}),
               std::invalid_argument);
}

/// E|z|^2 of a problem with a law, by the covariance of their states.
double cost_of(const H2Problem& p, const LinearSystem& F) {
  const Index n = p.A.rows(), k = F.A.rows();
  MatrixXd A(n + k, n + k), B(n + k, p.B_w.cols()), C(p.C_z.rows(), n + k);
  A << p.A + p.B_u * F.D * p.C_e, p.B_u * F.C, F.B * p.C_e, F.A;
  B << p.B_w + p.B_u * F.D * p.D_ew, F.B * p.D_ew;
  C << p.C_z + p.D_zu * F.D * p.C_e, p.D_zu * F.C;
  if (!(spectral_radius(A) < 1)) return std::numeric_limits<double>::infinity();
  const MatrixXd P = solve_stein(A.transpose(), B * B.transpose());
  return (C * P * C.transpose()).trace() + (p.D_zw + p.D_zu * F.D * p.D_ew).squaredNorm();
}

TEST(H2Law, IsTheCheapestOfItsNeighboursAndCostsWhatItSays) {
  Random draw(4);
  for (int i = 0; i < 30; ++i) {
    const Index n = draw.size(1, 6), m = draw.size(1, 2), q = draw.size(1, 2), w = n + q;
    H2Problem p{.A = draw.between(0.3, 1.2) * draw.matrix(n, n),
                .B_w = draw.matrix(n, w),
                .B_u = draw.matrix(n, m),
                .C_z = draw.matrix(n + m, n),
                .D_zw = draw.matrix(n + m, w),
                .D_zu = draw.matrix(n + m, m),
                .C_e = draw.matrix(q, n),
                .D_ew = draw.matrix(q, w)};
    const H2Law found = h2_law(p);
    const double cost = cost_of(p, found.law);
    EXPECT_NEAR(found.cost, cost, 1e-7 * cost) << i;
    for (int j = 0; j < 4; ++j) {
      LinearSystem other = found.law;
      MatrixXd& part = j == 0 ? other.A : j == 1 ? other.B : j == 2 ? other.C : other.D;
      part += 1e-3 * draw.matrix(part.rows(), part.cols());
      EXPECT_GT(cost_of(p, other), cost * (1 - 1e-9)) << i << ", part " << j;
    }
  }
}

}  // namespace
}  // namespace stillframe
