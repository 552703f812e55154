#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>

#include "core/numerics/extended/decompositions.hpp"
#include "core/numerics/worst.hpp"
#include "tests/support/quadruple.hpp"

// Twice the working precision against 113-bit arithmetic, and its matrix algebra against matrices
// of integers whose inverses and eigenvalues are known exactly.
namespace stillframe::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;

Quad quad(DoubleDouble a) { return static_cast<Quad>(a.high) + static_cast<Quad>(a.low); }

/// A normalised number of random digits and a size of 1e-10 to 1e10.
DoubleDouble random_number(std::mt19937& engine) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const double high = uniform(engine) * std::pow(10.0, 10 * uniform(engine));
  return DoubleDouble::fast_sum(high, high * 0x1p-53 * uniform(engine));
}

double relative(DoubleDouble found, Quad exact) {
  return static_cast<double>(abs_of(quad(found) - exact) / abs_of(exact));
}

/// High and low parts apart, as 113 bits do not hold all of a number whose low part is very small.
Quad sum_of(DoubleDouble a, DoubleDouble b) {
  return (static_cast<Quad>(a.high) + static_cast<Quad>(b.high)) +
         (static_cast<Quad>(a.low) + static_cast<Quad>(b.low));
}

TEST(DoubleDouble, OperationsAreRoundedBelowTheirBound) {
  std::mt19937 engine(1);
  double worst = 0;
  for (int k = 0; k < 20000; ++k) {
    const DoubleDouble a = random_number(engine), b = random_number(engine);
    // Now and then nearly opposite numbers, whose difference is all low parts.
    const DoubleDouble c = k % 2 == 0 ? b : -a * (1 + random_number(engine) * 0x1p-60);
    worst = worst_of({worst, relative(a + c, sum_of(a, c)), relative(a * b, quad(a) * quad(b)),
                      relative(a / b, quad(a) / quad(b)),
                      relative(sqrt(abs(a)), sqrt_of(abs_of(quad(a))))});
  }
  EXPECT_LE(worst, 0x1p-102);  // the bound in the header
  EXPECT_GE(worst, 0x1p-110);  // the comparison sees rounding at all
}

TEST(DoubleDouble, HighPartIsTheNearestDouble) {
  std::mt19937 engine(2);
  for (int k = 0; k < 2000; ++k) {
    const DoubleDouble a = random_number(engine) / random_number(engine);
    EXPECT_EQ(a.high, static_cast<double>(quad(a)));
    EXPECT_EQ(DoubleDouble(a.high) < a, a.low > 0);
  }
}

TEST(Decompositions, TheInverseOfHilbertsMatrixIsOfIntegers) {
  constexpr int n = 10;
  ExtendedMatrix H(n, n);
  MatrixXd inverse(n, n);
  const auto choose = [](int a, int b) {
    return std::round(
        std::exp(std::lgamma(a + 1.0) - std::lgamma(b + 1.0) - std::lgamma(a - b + 1.0)));
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      H(i, j) = DoubleDouble(1) / (i + j + 1);
      const double of_both = choose(i + j, i) * choose(i + j, i);
      inverse(i, j) = ((i + j) % 2 == 0 ? 1 : -1) * (i + j + 1.0) * choose(n + i, n - j - 1) *
                      choose(n + j, n - i - 1) * of_both;
    }
  }
  const ExtendedMatrix I = ExtendedMatrix::Identity(n, n);
  const auto L = cholesky_factor(H);
  ASSERT_TRUE(L.has_value());
  const ExtendedMatrix by_factor = backward_solve(*L, forward_solve(*L, I));
  for (const ExtendedMatrix& found : {solve(H, I), by_factor}) {
    const MatrixXd difference = stillframe::rounded(found - extended(inverse));
    // 2^-102 times the condition of 1.6e13, with n for the sums.
    EXPECT_LE(difference.norm(), 2e-31 * 1.6e13 * n * inverse.norm());
  }
  EXPECT_FALSE(cholesky_factor(-H).has_value());
}

TEST(Decompositions, QAndEigenvectorsAreOrthogonalInBothPrecisions) {
  std::mt19937 engine(3);
  ExtendedMatrix A(9, 6);
  for (Index j = 0; j < A.cols(); ++j) {
    for (Index i = 0; i < A.rows(); ++i) A(i, j) = random_number(engine);
  }
  const auto [Q, R] = orthogonalised(A);
  const double size = stillframe::rounded(A).norm();
  // Rounding of 2^-102, some ten times over in sums of nine.
  EXPECT_LE(stillframe::rounded(Q * R - A).norm(), 1e-29 * size);
  EXPECT_LE(stillframe::rounded(Q.transpose() * Q - ExtendedMatrix::Identity(6, 6)).norm(), 1e-29);
  EXPECT_EQ(stillframe::rounded(R)(3, 1), 0);
  const ExtendedMatrix S = A.transpose() * A;
  const auto [values, V] = symmetric_eigen(S);
  EXPECT_LE(stillframe::rounded(S * V - V * values.asDiagonal()).norm(),
            1e-28 * stillframe::rounded(S).norm());
  EXPECT_LE(stillframe::rounded(V.transpose() * V - ExtendedMatrix::Identity(6, 6)).norm(), 1e-28);
  for (Index i = 0; i + 1 < 6; ++i) EXPECT_TRUE(values(i) <= values(i + 1));
}

/// S D S^-1 with S = P P^T of Pascal's triangle P, whose determinant is 1: all integers.
TEST(Decompositions, EigenvaluesOfAnObliqueMatrixOfIntegersAreExact) {
  constexpr Index n = 8;
  MatrixXd P = MatrixXd::Zero(n, n), P_inverse = P;
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j <= i; ++j) {
      P(i, j) = j == 0 || j == i ? 1 : P(i - 1, j - 1) + P(i - 1, j);
      P_inverse(i, j) = ((i + j) % 2 == 0 ? 1 : -1) * P(i, j);
    }
  }
  MatrixXd D = MatrixXd::Zero(n, n);
  D.diagonal() << 1, 2, -3, -3, 5, 5, 5, 5;  // -3 +- 4 i, and 5 four times
  D(2, 3) = 4;
  D(3, 2) = -4;
  D(4, 4) = 3;
  const MatrixXd S = P * P.transpose(), S_inverse = P_inverse.transpose() * P_inverse;
  const VectorXcd found = eigenvalues(extended(S * D * S_inverse));
  const std::complex<double> expected[] = {1, 2, 3, {-3, 4}, {-3, -4}, 5, 5, 5};
  // Largest entry 1e9, condition of S 3e8: in doubles some 1e-1 would be left, here 1e-14.
  for (const auto value : expected) EXPECT_LE((found.array() - value).abs().minCoeff(), 1e-12);
  for (const auto value : found) {
    double nearest = 1;
    for (const auto e : expected) nearest = std::min(nearest, std::abs(value - e));
    EXPECT_LE(nearest, 1e-12);
  }
  for (Index i = 0; i + 1 < n; ++i) EXPECT_LE(std::abs(found(i)), std::abs(found(i + 1)));
}

}  // namespace
}  // namespace stillframe::test
