#include <gtest/gtest.h>

#include "core/control/robustness/draws.hpp"
#include "core/control/robustness/worst_case.hpp"
#include "core/numerics/worst.hpp"
#include "tests/robustness/frame.hpp"

namespace stillframe::robustness {
namespace {

using Eigen::VectorXd;

VectorXd corner(Eigen::Index p, unsigned bits) {
  VectorXd values(p);
  for (Eigen::Index j = 0; j < p; ++j) values(j) = (bits >> j & 1U) != 0 ? 1 : -1;
  return values;
}

/// The corner that is worst of all, found by trying every one.
WorstCase enumerated(const Evaluator& evaluator, Measure measure) {
  WorstCase worst;
  for (unsigned bits = 0; bits < 1U << evaluator.size(); ++bits) {
    const VectorXd values = corner(evaluator.size(), bits);
    const Outcome outcome = evaluator(values);
    if (bits > 0 && badness(outcome, measure) <= badness(worst.outcome, measure)) continue;
    worst.values = values;
    worst.outcome = outcome;
  }
  return worst;
}

SceneUncertainty of_frame(double stiffness, double delay) {
  SceneUncertainty uncertainty;
  uncertainty.stiffness = stiffness;
  uncertainty.delay_samples = delay;
  return uncertainty;
}

TEST(WorstCase, IsTheWorstOfAllCornersOfTheFrame) {
  static const FrameLoop frame;
  const Evaluator evaluator = frame.evaluator(of_frame(0.3, 0.1));
  ASSERT_EQ(evaluator.size(), 7);
  for (const Measure measure : measures) {
    const WorstCase expected = enumerated(evaluator, measure);
    const WorstCase found =
        search_worst(evaluator, measure, {sample(1, 0, 7), sample(1, 1, 7), sample(1, 2, 7)}, 2);
    ASSERT_EQ(found.outcome.verdict, Outcome::Verdict::stable);
    // Corners that the symmetry of the frame maps to one another differ by rounding.
    EXPECT_NEAR(badness(found.outcome, measure), badness(expected.outcome, measure), 1e-9);
    EXPECT_EQ(found.stable_part, 1);
    // It is the corners that matter: the nominal plant is far better.
    EXPECT_GT(badness(found.outcome, measure),
              badness(evaluator(VectorXd::Zero(7)), measure) + 1e-5);
  }
}

TEST(WorstCase, BoundaryOfStabilityInClosedForm) {
  // kappa = 0.8: the feedthrough of the actuator to its own sensor is a loop of gain 0.8 g.
  const Cart cart{.m = 2, .k = 800, .kappa = 0.8, .sample_time = 0.01};
  SceneUncertainty uncertainty;
  uncertainty.stiffness = 0.1;
  uncertainty.actuator_gain = 0.5;
  const Evaluator evaluator = cart.evaluator(uncertainty);
  const WorstCase worst = search_worst(evaluator, Measure::radius, {}, 1);
  const auto radius_at = [&](double part) {
    Cart other = cart;
    other.k *= 1 + 0.1 * part * worst.values(0);
    return other.radius(1 + 0.5 * part * worst.values(1));
  };
  EXPECT_EQ(worst.values(1), 1);
  EXPECT_NEAR(worst.outcome.radius, radius_at(1), 1e-11);  // as in test_evaluator.cpp
  ASSERT_GT(worst.outcome.radius, 1);
  // The search ends at 1e-4 of the way.
  EXPECT_LT(radius_at(worst.stable_part), 1);
  EXPECT_GT(radius_at(worst.stable_part + 1e-4), 1);
  // What explains it: without the gain's deviation the loop is stable, without the spring's not.
  EXPECT_EQ(worst.without.at(Parameter::Kind::actuator_gain).verdict, Outcome::Verdict::stable);
  EXPECT_EQ(worst.without.at(Parameter::Kind::stiffness).verdict, Outcome::Verdict::unstable);
  EXPECT_EQ(worst.without.size(), 2u);
}

TEST(WorstCase, AStartThatIsWorseThanAllCornersIsKept) {
  // sin(omega T) of the hold is largest between the corners of a wide box; a start there wins.
  const Cart cart{.m = 2, .k = 20000, .kappa = 0.3, .sample_time = 0.03};
  SceneUncertainty uncertainty;
  uncertainty.stiffness = 0.9;
  const Evaluator evaluator = cart.evaluator(uncertainty);
  double most = 0;
  VectorXd inside(1);
  for (double value = -0.99; value < 1; value += 0.01) {
    const double radius = evaluator(VectorXd::Constant(1, value)).radius;
    if (radius > most) inside(0) = value;
    most = worst_of(most, radius);
  }
  const double corners = worst_of(evaluator(VectorXd::Constant(1, -1)).radius,
                                  evaluator(VectorXd::Constant(1, 1)).radius);
  ASSERT_GT(most, corners + 1e-3);
  EXPECT_EQ(search_worst(evaluator, Measure::radius, {inside}, 2).values, inside);
}

TEST(WorstCase, TheSameForAnyNumberOfThreads) {
  static const FrameLoop frame;
  const Evaluator evaluator = frame.evaluator(of_frame(0.3, 0.6));
  const std::vector<VectorXd> starts{sample(1, 0, 7), sample(1, 1, 7)};
  const WorstCase one = search_worst(evaluator, Measure::radius, starts, 1);
  const WorstCase three = search_worst(evaluator, Measure::radius, starts, 3);
  EXPECT_EQ(one.values, three.values);
  EXPECT_EQ(one.evaluations, three.evaluations);
  EXPECT_EQ(one.outcome.radius, three.outcome.radius);
}

}  // namespace
}  // namespace stillframe::robustness
