#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "controller/answer.hpp"
#include "core/numerics/infinity.hpp"
#include "tests/controller/toy_plant.hpp"
#include "tests/support/allocation_count.hpp"

namespace stillframe::controller {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using stillframe_msgs::command_t;
using stillframe_msgs::measurement_t;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

class AnswerTest : public testing::Test {
 protected:
  AnswerTest() {
    measurement.run_id = 7;
    measurement.n_legs = 4;
    measurement.sigma = {1, -2, 3, -4};
    measurement.applied_force = {0.5, 0.25, 0, 1};
  }

  static Answer make(std::optional<double> limit = {}, bool active = true) {
    return Answer(law_from_gains(toy::gains(5)), limit, active);
  }

  void ask(Answer& answer) {
    answer.prepare(command);
    ++measurement.seq;
    measurement.time_ns += 1000000;
    answer.answer(measurement, command);
    EXPECT_EQ(command.run_id, measurement.run_id);
    EXPECT_EQ(command.seq, measurement.seq);
    EXPECT_EQ(command.time_ns, measurement.time_ns);
  }

  measurement_t measurement{};
  command_t command{};
};

TEST_F(AnswerTest, IsTheLawWithoutLimits) {
  Answer answer = make();
  Law law(law_from_gains(toy::gains(5)));
  VectorXd force(4);
  for (int k = 0; k < 20; ++k) {
    ask(answer);
    law.step(VectorXd::Map(measurement.sigma.data(), 4),
             VectorXd::Map(measurement.applied_force.data(), 4), force);
    EXPECT_EQ(force, VectorXd::Map(command.force.data(), 4));  // the same operations, the same bits
    EXPECT_GT(force.norm(), 1);
    EXPECT_FALSE(command.saturated);
  }
}

TEST_F(AnswerTest, LimitsAndCounts) {
  Answer answer = make(1.0);
  ask(answer);
  EXPECT_TRUE(command.saturated);
  for (const double f : command.force) EXPECT_LE(std::abs(f), 1.0);
  EXPECT_EQ(answer.n_saturated(), 1);
  measurement.sigma = measurement.applied_force;  // sigma_p = 0 and the law at its first sample
  Answer fresh = make(1.0);
  ask(fresh);
  EXPECT_FALSE(command.saturated);
  EXPECT_EQ(fresh.n_saturated(), 0);
}

TEST_F(AnswerTest, PassiveCommandsZero) {
  Answer answer = make({}, false);
  ask(answer);
  EXPECT_EQ(command.force, std::vector<double>(4, 0.0));
  EXPECT_EQ(answer.n_fallback(), 0);
}

TEST_F(AnswerTest, NonFiniteInputCommandsZeroAndLeavesTheLawAlone) {
  Answer answer = make(), reference = make();
  ask(answer);
  ask(reference);
  const measurement_t good = measurement;
  for (auto* values : {&measurement.sigma, &measurement.applied_force}) {
    measurement = good;
    values->at(2) = not_a_number;
    ask(answer);
    EXPECT_EQ(command.force, std::vector<double>(4, 0.0));
  }
  EXPECT_EQ(answer.n_fallback(), 2);
  measurement = good;
  ask(answer);
  const auto after = command.force;
  // To the law the refused sample was a missed one: both answer two samples after their last.
  measurement = good;
  ++measurement.seq;
  ask(reference);
  EXPECT_EQ(after, command.force);
}

TEST_F(AnswerTest, OverflowInTheLawCommandsZeroAndRecovers) {
  Answer answer = make(1.0);
  measurement.sigma = {1.7e308, 1.7e308, 1.7e308, 1.7e308};
  measurement.applied_force = {-1.7e308, 0, 0, 0};  // sigma - applied overflows
  ask(answer);
  EXPECT_EQ(command.force, std::vector<double>(4, 0.0));
  EXPECT_EQ(answer.n_fallback(), 1);
  measurement.sigma = {1e-3, 1e-3, 1e-3, 1e-3};
  measurement.applied_force = {0, 0, 0, 0};
  ask(answer);
  EXPECT_EQ(answer.n_fallback(), 1);
  for (const double f : command.force) EXPECT_TRUE(std::isfinite(f) && f != 0);
}

TEST_F(AnswerTest, DoesNotAllocate) {
  Answer answer = make(1.0);
  answer.prepare(command);
  const auto before = test::allocation_count();
  for (int k = 0; k < 10; ++k) answer.answer(measurement, command);
  measurement.sigma[0] = not_a_number;
  answer.answer(measurement, command);
  EXPECT_EQ(test::allocation_count(), before);
}

}  // namespace
}  // namespace stillframe::controller
