#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/linear/continuous_loop.hpp"
#include "core/linear/eigenvalues.hpp"
#include "core/linear/margins.hpp"
#include "core/linear/sampled_loop.hpp"
#include "core/worst.hpp"
#include "core/yaml/input_error.hpp"
#include "tests/core/random_loops.hpp"

namespace stillframe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

MatrixXd random_matrix(std::mt19937_64& random, Index n) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(n, n, [&] { return normal(random); });
}

// One entry that is not finite, anywhere, in a matrix of any size: never a radius below a bound.
// The memory that Eigen would answer from is filled with small numbers before.
TEST(Eigenvalues, AreUnknownOfWhatIsNotFinite) {
  std::mt19937_64 random(8);
  for (int round = 0; round < 500; ++round) {
    const Index n = 1 + static_cast<Index>(random() % 40);
    EXPECT_LT(spectral_radius(MatrixXd(1e-3 * MatrixXd::Identity(n, n))), 1);
    MatrixXd A = random_matrix(random, n) / (10.0 * static_cast<double>(n));
    A(static_cast<Index>(random() % static_cast<std::uint64_t>(n)),
      static_cast<Index>(random() % static_cast<std::uint64_t>(n))) = round % 3 == 0   ? nan
                                                                      : round % 3 == 1 ? infinity
                                                                                       : -infinity;
    EXPECT_FALSE(eigenvalues(A));
    EXPECT_FALSE(eigenvalues(Eigen::MatrixXcd(A.cast<std::complex<double>>())));
    EXPECT_EQ(spectral_radius(A), infinity);
    EXPECT_FALSE(spectral_radius(A) < 1);
    EXPECT_TRUE(spectral_radius(A) >= 1);
    EXPECT_FALSE(std::max(0.5, spectral_radius(A)) < 1);
  }
}

// V D V^-1 with D known and V orthogonal: the radius is that of D at every size of the numbers that
// doubles have, or it is not known.
TEST(Eigenvalues, OfTheLargestNumbersAreRightOrUnknown) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> exponent(-300, 308);
  int n_known = 0;
  for (int round = 0; round < 500; ++round) {
    const Index n = 2 + static_cast<Index>(random() % 10);
    const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(random_matrix(random, n)).householderQ();
    Eigen::VectorXd D = random_matrix(random, n).col(0);
    const double scale = std::pow(10.0, exponent(random));
    const double radius = spectral_radius(MatrixXd(scale * (Q * D.asDiagonal() * Q.transpose())));
    const double expected = scale * worst_of(D);
    if (radius == infinity) continue;
    ++n_known;
    // Symmetric, so well conditioned: n roundings of the largest.
    EXPECT_NEAR(radius / expected, 1, 1e-13) << scale;
  }
  EXPECT_GT(n_known, 400);
}

// A sound loop with one entry of its plant or its gains beyond all bounds: no radius that is called
// stable, no poles, no margins.
TEST(Eigenvalues, NoLoopOfAbsurdNumbersIsJudgedStable) {
  std::mt19937_64 random(10);
  int n_loops = 0;
  for (unsigned seed = 1; n_loops < 60; ++seed) {
    LoopSettings loop = test::random_loop(seed);
    if (!(spectral_radius(loop) < largest_stable_radius)) continue;
    ++n_loops;
    const double absurd = n_loops % 3 == 0 ? nan : n_loops % 3 == 1 ? infinity : 1e306;
    MatrixXd& in = n_loops % 2 == 0 ? loop.plant.A : loop.feedback.K_I;
    in(static_cast<Index>(random() % static_cast<std::uint64_t>(in.rows())),
       static_cast<Index>(random() % static_cast<std::uint64_t>(in.cols()))) = absurd;
    double radius = infinity;
    try {
      radius = spectral_radius(loop);
    } catch (const Refusal&) {
    }
    // An integrator without bound leaves a pole at 1, to rounding, which is not stable either.
    EXPECT_FALSE(radius < largest_stable_radius) << seed << " " << absurd;
    EXPECT_THROW(margins(loop), Refusal) << seed;
    if (!std::isfinite(absurd)) {
      EXPECT_THROW(closed_loop_poles(loop.plant, loop.feedback), Refusal) << seed;
    }
  }
}

TEST(Eigenvalues, AnEmptyMatrixHasNone) {
  EXPECT_EQ(eigenvalues(MatrixXd(0, 0))->size(), 0);
  EXPECT_EQ(spectral_radius(MatrixXd(0, 0)), 0);
}

}  // namespace
}  // namespace stillframe
