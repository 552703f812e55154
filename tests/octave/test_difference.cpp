// The measures of difference see a part in 1e8 where ten times less is allowed.

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>

#include "tests/octave/difference.hpp"

namespace stillframe::octave {
namespace {

using Complex = std::complex<double>;
using Eigen::VectorXcd;

constexpr double part = 1e-8;
// Rounding of numbers of 1e-8 beside one: 1e-16 / 1e-8.
constexpr double rounding = 1e-7 * part;

TEST(PoleDifference, IsOfTheNearestInAnyOrder) {
  const Eigen::Vector4cd poles(Complex(-1, 2), Complex(-1, -2), Complex(-30, 0), Complex(-0.1, 0));
  const Eigen::Vector4cd reversed = poles.reverse();
  EXPECT_EQ(pole_difference(reversed, poles), 0);
  for (Eigen::Index i = 0; i < 4; ++i) {
    Eigen::Vector4cd others = reversed;
    others(i) *= 1 + part;
    EXPECT_NEAR(pole_difference(others, poles), part, rounding);
  }
}

TEST(PoleDifference, TakesEachOnceAndTellsHalfPlanes) {
  const Eigen::Vector2cd twice(1, 1), once(1, 2), stable(Complex(-1, 5), Complex(-1, -5));
  EXPECT_EQ(pole_difference(twice, once), 0.5);
  EXPECT_EQ(pole_difference(once, twice), 1);
  EXPECT_GT(pole_difference(-stable, stable), 0.3);
}

TEST(PoleDifference, SmallOnesAreComparedWithAPartOfTheLargest) {
  const Eigen::Vector2cd poles(1000, 0.01);
  EXPECT_NEAR(pole_difference(Eigen::Vector2cd(1000, 0.01 + part), poles), part, rounding);
  // zero but for the square root of rounding, 1.5e-8 of the largest
  EXPECT_EQ(pole_difference(Eigen::Vector2cd(1000, 1e-5), Eigen::Vector2cd(1000, -1e-5)), 0);
  EXPECT_GT(pole_difference(Eigen::Vector2cd(1000, 1e-4), Eigen::Vector2cd(1000, 0)), part);
}

TEST(Difference, OfMatricesColumnsAndValues) {
  Eigen::Matrix2cd b;
  b << 100, 2, 1e-3, 1;
  Eigen::Matrix2cd a = b;
  a(1, 1) += 2 * part;
  EXPECT_NEAR(matrix_difference(a, b), 0.02 * part, rounding);
  EXPECT_NEAR(column_difference(a, b), part, rounding);
  EXPECT_NEAR(value_difference(a, b), 2 * part, rounding);
  a = b;
  a(1, 0) += 0.1 * part;
  EXPECT_NEAR(value_difference(a, b), part, rounding);
}

TEST(Difference, IsInfiniteWhereNothingCanBeCompared) {
  const VectorXcd two = VectorXcd::Ones(2), three = VectorXcd::Ones(3), none(0);
  const VectorXcd lost = two * std::numeric_limits<double>::quiet_NaN();
  for (const auto difference : {matrix_difference, column_difference, value_difference}) {
    EXPECT_EQ(difference(none, none), 0);
    for (const auto& [a, b] : {std::pair{two, three}, {lost, two}, {two, lost}, {two, none}}) {
      EXPECT_TRUE(std::isinf(difference(a, b)));
      EXPECT_TRUE(std::isinf(pole_difference(a, b)));
    }
  }
}

}  // namespace
}  // namespace stillframe::octave
