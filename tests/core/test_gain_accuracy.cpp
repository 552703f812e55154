#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <iostream>
#include <numbers>

#include "core/control/design/gain_design.hpp"
#include "core/numerics/extended/decompositions.hpp"
#include "core/numerics/worst.hpp"
#include "tests/core/random_pairs.hpp"
#include "tests/support/quadruple.hpp"

// What the exact order costs in digits: as it is designed, and rounded to doubles.
namespace stillframe::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

struct Pair {
  LegMatrices legs;
  double of_M = 1, of_K = 1;  ///< condition numbers
  ModeTarget target;
};

/// Sizes 1 to 12, every condition number up to 1e8, in every fourth pair exactly that; masses and
/// stiffnesses of many sizes; targets far below and far above the modes, of little damping and of
/// much.
Pair random_pair(int k, std::mt19937& engine) {
  std::uniform_real_distribution<double> exponent(0, 8), size(-3, 3);
  const auto condition = [&](bool largest) {
    return largest ? 1e8 : std::pow(10, exponent(engine));
  };
  const Index n = 1 + k % 12;
  Pair pair;
  pair.of_M = condition(k % 4 == 0 || k % 4 == 1);
  pair.of_K = condition(k % 4 == 0);
  pair.legs = {std::pow(10, size(engine)) * random_spd(n, pair.of_M, engine),
               std::pow(10, 3 + size(engine)) * random_spd(n, pair.of_K, engine)};
  constexpr double dampings[] = {0.05, 0.3, 0.7, 0.9, 2};
  pair.target = {std::pow(10, size(engine)), dampings[k % 5]};
  return pair;
}

QuadMatrix quad(const ExtendedMatrix& A) {
  return A.unaryExpr([](DoubleDouble a) -> double { return a.high; }).cast<Quad>() +
         A.unaryExpr([](DoubleDouble a) -> double { return a.low; }).cast<Quad>();
}

double norm(const QuadMatrix& A) { return A.cast<double>().norm(); }

/// The property.
TEST(GainAccuracy, ExactOrderPutsAllPolesOfTwoHundredRandomPairsOnTheTarget) {
  std::mt19937 engine(21);
  double worst = 0, worst_residual = 0;
  for (int k = 0; k < 200; ++k) {
    const auto [legs, of_M, of_K, target] = random_pair(k, engine);
    const auto [omega_d, zeta] = target;
    const Index n = legs.M.rows();
    const GainDesign design = extended_gains(legs, {target}, GainOrder::exact);
    const VectorXcd poles = closed_loop_poles(legs, design, omega_d);
    ASSERT_EQ(poles.size(), 3 * n);
    EXPECT_EQ(poles.head(n), VectorXcd::Zero(n));  // the integrators
    worst = worst_of(worst, distance_from_target(poles.tail(2 * n), omega_d, zeta));
    // The second way, in 113-bit arithmetic: s (s + 2 zeta omega_d) = -omega_d^2 lambda of the
    // eigenvalues lambda of M^-1 X^-1 K / omega_d^2, which must be I, if K_I = 2 zeta omega_d X.
    const QuadMatrix M = legs.M.cast<Quad>(), K = legs.K.cast<Quad>(), X = quad(design.X);
    const Quad omega = omega_d, twice = 2 * static_cast<Quad>(zeta) * omega;
    const QuadMatrix N = solve(M, solve(X, K)) / (omega * omega);
    worst_residual = worst_of({worst_residual, norm(N - QuadMatrix::Identity(n, n)),
                               norm(quad(design.K_I) - twice * X) / norm(twice * X)});
  }
  std::cout << "worst pole " << worst << ", worst residual " << worst_residual << "\n";
  EXPECT_LE(worst, 1e-9);  // the bound
  // 2^-102 times both conditions, 2e-15, times n for the sums; M^-1 N M takes the square root of
  // the condition of M more; poles add their own rounding of 2^-53.
  EXPECT_LE(worst, 1e-13);
  EXPECT_LE(worst_residual, 1e-10);
}

/// Each root of the pair moves by |ds| = omega_d^2 |d lambda| / |2 s + 2 zeta omega_d|, where
/// lambda is an eigenvalue of (I + L^-1 X^-1 (dX s + dK_I) L / (s + 2 zeta omega_d))^-1, L L^T = M.
/// With X^-1 = omega_d^2 M K^-1 and dX, dK_I at most 2^-53 of each entry of K_P and K_I,
///   |d lambda| <= 2^-53 omega_d^2 |M| |K^-1| (|s| |K_P| + |K_I|) / |s + 2 zeta omega_d|,
/// which for modes above the target is about 2^-53 sqrt(n) (1 + 2 zeta) cond(M) cond(K). Relative
/// to |s|, the larger of both roots.
double bound_of_rounding(const LegMatrices& legs, const ForceFeedback& gains,
                         const ModeTarget& target) {
  const auto [omega_d, zeta] = target;
  const double of_M = Eigen::SelfAdjointEigenSolver<MatrixXd>(legs.M).eigenvalues().maxCoeff();
  const double of_K = Eigen::SelfAdjointEigenSolver<MatrixXd>(legs.K).eigenvalues().minCoeff();
  double bound = 0;
  for (const std::complex<double> s : target_roots(omega_d, zeta)) {
    const double d_lambda = 0x1p-53 * omega_d * omega_d * (of_M / of_K) *
                            (std::abs(s) * gains.K_P.norm() + gains.K_I.norm()) /
                            std::abs(s + 2 * zeta * omega_d);
    bound = worst_of(bound, omega_d * omega_d * d_lambda /
                                (std::abs(2.0 * s + 2 * zeta * omega_d) * std::abs(s)));
  }
  return bound;
}

TEST(GainAccuracy, RoundingToDoublesCostsBothConditionNumbersAndNoMore) {
  std::mt19937 engine(22);
  double largest_ratio = 0, worst_where_promised = 0;
  int judged = 0, promised = 0;
  for (int k = 0; k < 400; ++k) {
    const auto [legs, of_M, of_K, target] = random_pair(k, engine);
    const auto [omega_d, zeta] = target;
    const ForceFeedback gains = extended_gains(legs, {target}, GainOrder::exact).gains();
    const double bound = bound_of_rounding(legs, gains, target);
    if (bound > 0.01) continue;  // no first order there
    const VectorXcd poles = closed_loop_poles(legs, gains, omega_d);
    const double error = distance_from_target(poles.tail(2 * legs.M.rows()), omega_d, zeta);
    // 2 % for the second order, and the rounding of the poles themselves.
    EXPECT_LE(error, 1.02 * bound + 4e-16)
        << "n " << legs.M.rows() << ", conditions " << of_M << " and " << of_K;
    largest_ratio = worst_of(largest_ratio, (error - 4e-16) / bound);
    ++judged;
    if (bound > 1e-9) continue;
    worst_where_promised = worst_of(worst_where_promised, error);
    ++promised;
  }
  std::cout << judged << " pairs, error at most " << largest_ratio << " of its bound; " << promised
            << " of them promised 1e-9, worst " << worst_where_promised << "\n";
  EXPECT_GE(judged, 200);
  EXPECT_GE(promised, 50);
  EXPECT_LE(worst_where_promised, 1e-9);
  EXPECT_GE(largest_ratio, 0.01);  // the bound is no idle one
}

TEST(GainAccuracy, GainsAreRoundedOnce) {
  std::mt19937 engine(23);
  for (int k = 0; k < 24; ++k) {
    const auto [legs, of_M, of_K, target] = random_pair(k, engine);
    const Index n = legs.M.rows();
    const Quad omega = target.omega_d;
    const QuadMatrix X =
        solve(legs.M.cast<Quad>(), legs.K.cast<Quad>()).transpose() / (omega * omega);
    const QuadMatrix K_P = X - QuadMatrix::Identity(n, n);
    const ForceFeedback gains = extended_gains(legs, {target}, GainOrder::exact).gains();
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < n; ++j) {
        const double away = std::abs(static_cast<double>(gains.K_P(i, j) - K_P(i, j)));
        // Half a unit in the last place of the entry; 2^-102 cond(M) of the largest before that.
        EXPECT_LE(away, 0x1p-53 * std::abs(gains.K_P(i, j)) + 1e-29 * of_M * norm(X));
      }
    }
  }
}

/// Where the loop inverts X in doubles, it loses what X has lost by rounding.
TEST(GainAccuracy, TheLoopOfTheRoundedGainsIsDecoupledAsFarAsRoundingLetsIt) {
  std::mt19937 engine(12);
  const double omega_d = 30, zeta = 0.7;
  for (const double condition : {1e2, 1e4, 1e6, 1e8}) {
    double worst = 0;
    for (const Index n : {1, 2, 3, 6, 9}) {
      // Ill-conditioned masses on even legs for odd n, even masses on ill-conditioned legs for even
      // n.
      const double of_M = n % 2 == 1 ? condition : 10.0, of_K = n % 2 == 1 ? 10.0 : condition;
      const LegMatrices legs{random_spd(n, of_M, engine), 1e6 * random_spd(n, of_K, engine)};
      const ForceFeedback gains = design_gains(legs, omega_d, zeta, GainOrder::exact, 0);
      using Complex = std::complex<double>;
      using Eigen::MatrixXcd;
      const MatrixXd X = gains.K_P + MatrixXd::Identity(n, n);
      // sigma = G_22 sigma_a + ... with G_22 = s^2 (s^2 + K M^-1)^-1, whose loop must act as the
      // target.
      const Complex s(0, 0.9 * omega_d);
      const MatrixXcd K_M = (omega_d * omega_d * X).cast<Complex>(), I = MatrixXcd::Identity(n, n);
      const MatrixXcd G_22 = (s * s * I + K_M).partialPivLu().solve(s * s * I);
      const MatrixXcd loop = (I - G_22 * gains(s)).partialPivLu().solve(G_22) * X;
      const Complex expected = s * s / (s * s + 2 * zeta * omega_d * s + omega_d * omega_d);
      worst = worst_of(worst, (loop - expected * I).norm() / std::abs(expected));
    }
    std::cout << "condition " << condition << ": decoupling " << worst << "\n";
    // The loop inverts X, whose condition is that of M times that of K.
    EXPECT_LE(worst, 1e-15 * 10 * 10 * condition) << condition;
  }
}

}  // namespace
}  // namespace stillframe::test
