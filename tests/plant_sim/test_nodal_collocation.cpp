#include <gtest/gtest.h>

#include <cmath>

#include "plant_sim/nodal/collocation.hpp"

namespace stillframe::nodal {
namespace {

using Eigen::Index;

class Radau : public testing::TestWithParam<Index> {
 protected:
  Collocation method_{GetParam()};
  Index s_ = GetParam();
  // Rounding of sums of s terms, times the condition of the powers (below 1e4 for s = 7).
  static constexpr double rounding = 1e-12;
};

TEST_P(Radau, IntegratesPolynomialsOfItsOrder) {
  for (int k = 0; k < 2 * s_ - 1; ++k) {
    const double sum = method_.A.row(s_ - 1) * method_.c.array().pow(k).matrix();
    EXPECT_NEAR(sum, 1.0 / (k + 1), rounding) << k;
  }
  const auto k = static_cast<double>(2 * s_ - 1);
  const double beyond = method_.A.row(s_ - 1) * method_.c.array().pow(k).matrix();
  EXPECT_GT(std::abs(beyond - 1 / (k + 1)), 10 * rounding) << "the order is higher than it can be";
}

TEST_P(Radau, StagesIntegratePolynomials) {
  for (int k = 0; k < s_; ++k) {
    const Eigen::VectorXd integrals = method_.A * method_.c.array().pow(k).matrix();
    const Eigen::VectorXd exact = method_.c.array().pow(k + 1) / (k + 1);
    EXPECT_LT((integrals - exact).norm(), rounding) << k;
  }
}

TEST_P(Radau, EigenvectorsSplitTheMethod) {
  Eigen::MatrixXd sum = method_.gamma * method_.T_real * method_.T_inverse_real;
  for (size_t k = 0; k < method_.mu.size(); ++k) {
    const auto j = static_cast<Index>(k);
    sum += 2 * (method_.mu[k] * method_.T.col(j) * method_.T_inverse.row(j)).real();
  }
  EXPECT_LT((sum - method_.A).norm(), rounding);
  EXPECT_EQ(static_cast<Index>(method_.mu.size()), (s_ - 1) / 2);
  EXPECT_GT(method_.gamma, 0);
}

TEST_P(Radau, EmbeddedFormulaHasOrderOfTheStages) {
  // b + d with the weight gamma at 0 integrates polynomials below degree s exactly: d adds to the
  // weights what gamma at 0 takes from the constant, and nothing else.
  EXPECT_NEAR(method_.d.sum(), -method_.gamma, rounding);
  for (int k = 1; k < s_; ++k) {
    EXPECT_NEAR(method_.d.dot(method_.c.array().pow(k).matrix()), 0, rounding) << k;
  }
}

TEST_P(Radau, ExtrapolatesItsPolynomial) {
  Eigen::RowVectorXd weights(s_);
  method_.extrapolate(1.7, weights);
  const Eigen::VectorXd values = method_.c.array().pow(static_cast<double>(s_ - 1));
  EXPECT_NEAR(weights.dot(values), std::pow(1.7, static_cast<double>(s_ - 1)), 1e3 * rounding);
}

INSTANTIATE_TEST_SUITE_P(Stages, Radau, testing::Values<Index>(3, 5, 7));

TEST(Collocation, KnowsTheMethodOfThreeStages) {
  // Hairer and Wanner, II, table IV.5.6.
  const Collocation method(3);
  EXPECT_NEAR(method.c(0), (4 - std::sqrt(6)) / 10, 1e-15);
  EXPECT_NEAR(method.A(0, 0), (88 - 7 * std::sqrt(6)) / 360, 1e-15);
  EXPECT_NEAR(method.A(2, 2), 1.0 / 9, 1e-15);
  EXPECT_THROW(Collocation(2), std::invalid_argument);
  EXPECT_THROW(Collocation(-1), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe::nodal
