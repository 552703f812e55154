#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/control/continuous_loop.hpp"
#include "core/control/margins.hpp"
#include "core/errors/input_error.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/worst.hpp"
#include "core/systems/sampled_loop.hpp"
#include "tests/core/random_loops.hpp"

namespace stillframe {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

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

// Modes in pairs of one frequency that hardly couple, undamped: Eigen's QR iteration alone does not
// end on some of them.
TEST(Eigenvalues, OfEqualModesThatHardlyCoupleAreFound) {
  for (const double other : {1.0, 2.0, 3.3}) {
    for (const double coupling : {1e-9, 3e-10, 1e-10, 1e-11}) {
      const Index n = 4;
      MatrixXd A = MatrixXd::Zero(2 * n, 2 * n);
      A.topRightCorner(n, n).setIdentity();
      for (Index i = 0; i < n; ++i) A(n + i, i) = i < 2 ? -1 : -other * other;
      for (Index i = 0; i < 2; ++i) {
        A(n + i, n + i + 1) = coupling;
        A(n + i + 1, n + i) = -coupling;
      }
      const auto values = eigenvalues(A);
      ASSERT_TRUE(values) << other << " " << coupling;
      for (const std::complex<double> value : *values) {
        const double off = std::min(std::abs(std::abs(value.imag()) - 1),
                                    std::abs(std::abs(value.imag()) - other));
        EXPECT_LT(off, 2 * coupling) << value;
        // A skew part moves nothing off the axis: rounding of 8 numbers of up to 3.3^2.
        EXPECT_LT(std::abs(value.real()), 1e-13) << value;
      }
      const auto form = real_schur_form(A);
      ASSERT_TRUE(form);
      EXPECT_LT((form->Q * form->T * form->Q.transpose() - A).norm(), 1e-14 * 8 * A.norm());
      EXPECT_LT((form->Q.transpose() * form->Q - MatrixXd::Identity(2 * n, 2 * n)).norm(), 1e-13);
    }
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
