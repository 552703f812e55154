#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "controller/arming.hpp"
#include "controller/histogram.hpp"
#include "controller/limits.hpp"
#include "controller/presence.hpp"
#include "controller/screen.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/worst.hpp"

namespace stillframe::controller {
namespace {

using Eigen::VectorXd;

VectorXd vector(std::initializer_list<double> values) {
  VectorXd out(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), out.begin());
  return out;
}

Measurement measurement(std::int64_t seq, double sigma = 1, double applied = 0) {
  return {.seq = seq,
          .time_ns = seq * 1'000'000,
          .received_ns = 0,
          .sigma = VectorXd::Constant(2, sigma),
          .applied = VectorXd::Constant(2, applied),
          .floor = {}};
}

/// s, the age of sample k some samples after the first.
constexpr double age(int k, double now) { return (now - k) * 1e-3; }

TEST(Screen, TakesOnlyWhatIsNew) {
  Screen screen({}, 1000);
  EXPECT_TRUE(screen.is_new(measurement(0), age(0, 0.5)));
  EXPECT_FALSE(screen.is_new(measurement(0), age(0, 1)));  // twice
  EXPECT_TRUE(screen.is_new(measurement(3), age(3, 3)));
  EXPECT_FALSE(screen.is_new(measurement(2), age(2, 3)));  // overtaken
  Measurement replayed = measurement(4);                   // another number, the old time
  replayed.time_ns = 1'000'000;
  EXPECT_FALSE(screen.is_new(replayed, age(1, 4)));
  // From the future, and without any harm to those that come in their time.
  EXPECT_FALSE(screen.is_new(measurement(1000), age(1000, 4)));
  EXPECT_TRUE(screen.is_new(measurement(4), age(4, 4)));
}

TEST(Screen, JudgesAgeAndValues) {
  const Screen screen({}, 1000);
  EXPECT_EQ(screen.judge(measurement(7), 0.5e-3), Defect::none);
  EXPECT_EQ(screen.judge(measurement(8), 1.001e-3), Defect::late);
  EXPECT_EQ(screen.judge(measurement(9, std::nan("")), 0.5e-3), Defect::not_finite);
  EXPECT_EQ(screen.judge(measurement(10, 1, INFINITY), 0.5e-3), Defect::not_finite);
  EXPECT_EQ(screen.judge(measurement(11, -1.001e5), 0.5e-3), Defect::out_of_range);
  EXPECT_EQ(screen.judge(measurement(12, 1, 2e5), 0.5e-3), Defect::out_of_range);
}

void commanded_last(Limits& limits, const VectorXd& force) {
  const auto set = [&](VectorXd& last) { last = force; };
  limits.visit(set);
}

TEST(Limits, ForceRateAndPower) {
  Policy policy;
  VectorXd force = vector({5, -7, 0.5});
  Limits force_only(2.0, policy, 3, 1e-3);
  EXPECT_TRUE(force_only.pass(force).limited);
  EXPECT_EQ(force, vector({2, -2, 0.5}));
  EXPECT_FALSE(force_only.pass(force).limited);  // at the limit is not beyond it

  policy.rate_limit_n_per_s = 100;
  Limits rate({}, policy, 3, 1e-3);
  commanded_last(rate, vector({0.2, 0, 0}));
  force = vector({1, -1, 0.05});
  EXPECT_TRUE(rate.pass(force).limited);
  EXPECT_LT((force - vector({0.3, -0.1, 0.05})).norm(), 1e-15);

  Policy power;
  power.power_limit_w = 0.5;
  power.actuator_stiffness_n_per_m = 1e6;
  Limits limits({}, power, 3, 1e-3);
  const VectorXd last = vector({10, -10, -10});
  commanded_last(limits, last);
  force = vector({100, -100, 100});
  EXPECT_TRUE(limits.pass(force).limited);
  // The energy of the actuator grows by P dt, from nothing where the force goes through zero.
  const double energy = 0.5 * 1e-3;
  EXPECT_NEAR((force(0) * force(0) - 100) / 2e6, energy, 1e-15);
  EXPECT_NEAR(force(1), -force(0), 1e-12);
  EXPECT_NEAR(force(2) * force(2) / 2e6, energy, 1e-15);
  // Letting go is not limited.
  commanded_last(limits, last);
  force = vector({0, -1, -9});
  EXPECT_FALSE(limits.pass(force).limited);

  EXPECT_THROW(Limits(0.0, {}, 3, 1e-3), std::invalid_argument);
  EXPECT_THROW(Limits(std::nan(""), {}, 3, 1e-3), std::invalid_argument);
}

// Whatever is asked for, and whatever was met before: what passes is finite, within the limit, and
// one sample's change away from what passed last.
TEST(Limits, NothingElseEverPasses) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> decades(-3, 6);
  std::bernoulli_distribution rare(0.02);
  const auto any = [&](double) {
    if (rare(random)) return std::nan("");
    if (rare(random)) return random() % 2 ? infinity : -infinity;
    return (random() % 2 ? 1 : -1) * std::pow(10, decades(random));
  };
  Policy policy;
  policy.rate_limit_n_per_s = 2000;
  Limits limits(30.0, policy, 6, 1e-3);
  VectorXd last = VectorXd::Zero(6), force = last;
  for (int k = 0; k < 100'000; ++k) {
    if (random() % 50 == 0) {
      limits.let_go();
      last.setZero();
    }
    force = last.unaryExpr(any);
    const VectorXd wanted = force;
    const bool limited = limits.pass(force).limited;
    ASSERT_TRUE(force.allFinite());
    ASSERT_LE(worst_of(force), 30);
    ASSERT_LE(worst_of(force - last), 2 * (1 + 1e-14));  // rounding of the sum
    ASSERT_EQ(limited, !(force.array() == wanted.array()).all());
    last = force;
  }
}

class ArmingTest : public testing::Test {
 protected:
  Fault judge(const std::function<double(int, int)>& sigma, const Policy& policy = {}) {
    Arming arming(2, policy, 1000);
    for (int k = 0; !arming.complete(); ++k) {
      const VectorXd now = vector({sigma(0, k), sigma(1, k)});
      arming.add(now);
    }
    offset = doubt = VectorXd::Zero(2);
    return arming.judge(offset, doubt);
  }
  VectorXd offset, doubt;
};

TEST_F(ArmingTest, RemovesAnOffsetAndLeavesMotionAlone) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  EXPECT_EQ(judge([&](int leg, int) { return (leg == 0 ? 3.0 : 0.0) + normal(random); }),
            Fault::none);
  // 496 samples of standard deviation 1: a standard error of 0.045.
  EXPECT_NEAR(offset(0), 3, 4 * 0.045);
  EXPECT_EQ(offset(1), 0);
  // A vibration of 14 Hz that is not a whole number of periods long has a mean, and no offset.
  EXPECT_EQ(judge([](int leg, int k) { return std::sin(0.0873 * k + leg); }), Fault::none);
  EXPECT_EQ(offset, VectorXd::Zero(2));
}

// Of noise without an offset, white or as slow as what a floor leaves, an offset is removed from
// less than one arming of six legs in a thousand.
TEST_F(ArmingTest, RemovesNoOffsetThatIsNotThere) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  for (const double memory : {0.0, 0.9}) {  // 0.9: 10 ms at 1 kHz, a third of a batch
    constexpr int n = 30'000;
    int removed = 0;
    VectorXd now = VectorXd::Zero(6), offsets = now, doubts = now;
    Arming arming(6, {}, 1000);
    for (int i = 0; i < n / 6; ++i) {
      arming.restart();
      while (!arming.complete()) {
        for (double& value : now) value = memory * value + normal(random);
        arming.add(now);
      }
      EXPECT_EQ(arming.judge(offsets, doubts), Fault::none);
      removed += (offsets.array() != 0).any() ? 1 : 0;
    }
    // One in 1500 expected of white noise: of 5000 3.3, and more than 12 once in 1e4; noise with a
    // memory has wider means, which the scatter of the batches tells.
    EXPECT_LE(removed, 12) << memory;
  }
}

TEST_F(ArmingTest, FindsDeadSensorsAndLargeOffsets) {
  EXPECT_EQ(judge([](int leg, int k) { return leg == 1 ? 0.25 : k % 3; }), Fault::not_alive);
  Policy lenient;
  lenient.require_motion = false;
  EXPECT_EQ(judge([](int leg, int k) { return leg == 1 ? 0.25 : k % 3; }, lenient), Fault::none);
  EXPECT_EQ(judge([](int, int k) { return 51 + 0.1 * (k % 3); }), Fault::offset);
  Policy too_short;
  too_short.arming_s = 0.005;
  EXPECT_THROW(Arming(2, too_short, 1000), std::invalid_argument);
}

TEST(Histogram, QuantilesAreThoseOfTheSortedTimes) {
  std::mt19937_64 random(2);
  std::lognormal_distribution<double> times(10, 1.5);
  Histogram histogram;
  std::vector<double> sorted;
  for (int i = 0; i < 20'000; ++i) {
    sorted.push_back(std::floor(times(random)));
    histogram.add(static_cast<std::int64_t>(sorted.back()));
  }
  std::sort(sorted.begin(), sorted.end());
  for (const double part : {0.01, 0.5, 0.9, 0.99, 0.999}) {
    const double exact = sorted[static_cast<size_t>(std::ceil(part * 20'000)) - 1];
    EXPECT_GE(histogram.quantile(part), exact);
    EXPECT_LE(histogram.quantile(part), exact * std::exp2(1.0 / 64) * (1 + 1e-12)) << part;
  }
  EXPECT_EQ(static_cast<double>(histogram.worst_ns()), sorted.back());
  EXPECT_EQ(histogram.quantile(1), sorted.back());
  EXPECT_EQ(histogram.count(), 20'000);
  Histogram both;
  both.add(histogram);
  both.add(histogram);
  EXPECT_EQ(both.count(), 40'000);
  EXPECT_EQ(both.quantile(0.5), histogram.quantile(0.5));
  EXPECT_EQ(Histogram{}.quantile(0.5), 0);
  Histogram extreme;
  for (const std::int64_t t : {std::int64_t{-5}, std::int64_t{0}, std::int64_t{1} << 60}) {
    extreme.add(t);
  }
  EXPECT_EQ(extreme.count(), 3);
}

// Of two controllers exactly one gives way, whatever their states, ages and numbers.
// Of a controller that was killed in sample 0 a plant says that it is obeyed as long as its
// amplifiers hold, ten samples, and the loop hears it a sample late.
TEST(Presence, OneThatIsGoneOverrulesNobody) {
  constexpr std::int64_t since = 5;
  for (const double rate_hz : {1.0, 10.0, 70.0, 1000.0, 1e5}) {
    const auto after = [&](double seconds) {
      return is_overruled(since, since + std::llround(seconds * 1e9), rate_hz);
    };
    EXPECT_FALSE(after(12 / rate_hz)) << rate_hz;
    // One that lives is found within a fifth of a second, or when it would have been let go of.
    EXPECT_FALSE(after(0.199)) << rate_hz;
    EXPECT_TRUE(after(std::max(0.201, 15.1 / rate_hz))) << rate_hz;
  }
  EXPECT_FALSE(is_overruled(0, 1'000'000'000'000, 1000));
}

TEST(Presence, ExactlyOneOfTwoGivesWay) {
  using stillframe_msgs::controller_status_t;
  const auto said = [](const Presence& presence, State state) {
    controller_status_t status{};
    status.instance = presence.instance();
    status.started_ns = presence.started_ns();
    status.state = static_cast<std::int32_t>(state);
    return status;
  };
  for (const std::int64_t later : {0, 1}) {
    const Presence a(10, 100), b(20, 100 + later);
    for (int i = 0; i <= static_cast<int>(State::fault); ++i) {
      for (int j = 0; j <= static_cast<int>(State::fault); ++j) {
        const auto own = static_cast<State>(i), other = static_cast<State>(j);
        const bool a_goes = a.reason_to_leave(own, said(b, other)).has_value();
        const bool b_goes = b.reason_to_leave(other, said(a, own)).has_value();
        EXPECT_NE(a_goes, b_goes) << i << " " << j;
      }
    }
    EXPECT_FALSE(a.reason_to_leave(State::idle, said(b, State::idle)));
    EXPECT_TRUE(a.reason_to_leave(State::idle, said(b, State::active)));
  }
}

}  // namespace
}  // namespace stillframe::controller
