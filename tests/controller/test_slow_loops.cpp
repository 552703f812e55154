#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "controller/command_watch.hpp"
#include "controller/pace.hpp"
#include "controller/slow_loops.hpp"
#include "core/numerics/worst.hpp"
#include "tests/controller/rig.hpp"

// What is told in seconds holds at every legal rate, and a loop below 200 Hz does its work as one
// of 200 Hz does, sample by sample.
namespace stillframe::controller {
namespace {

using Eigen::VectorXd;

/// The frame and the loop of the bench, as much slower as they are sampled.
Gains slow_gains(double rate_hz) {
  Gains gains = toy::damped_gains(5, 1000);
  const double slower = rate_hz / gains.sample_rate_hz;
  const auto m = gains.n_legs();
  gains.sample_rate_hz = rate_hz;
  gains.leak_hz *= slower;
  gains.K_I *= slower;
  gains.plant.A.bottomRightCorner(m, m) *= slower;
  gains.plant.A.bottomLeftCorner(m, m) *= slower * slower;
  gains.plant.C *= slower * slower;
  return gains;
}

/// Noise below a hundredth of the rate, down to the slowest: what a floor does to a loop of a slow
/// target. Of 0.1 m/s^2 forces stay within the limit.
Rig::Floor floor_of_noise() {
  return [random = std::mt19937_64(3), normal = std::normal_distribution<double>()](
             std::int64_t, VectorXd& w) mutable {
    const double part = 1 - std::exp(-two_pi / 100);
    for (double& value : w) value += part * (0.1 * normal(random) - value);
  };
}

class SlowLoop : public testing::TestWithParam<double> {
 protected:
  SlowLoop() : rig(default_policy(GetParam()), true, slow_gains(GetParam())) {
    rig.floor = floor_of_noise();
  }
  /// 16 batches of six samples, a ramp of 200, and a few.
  bool becomes_active() { return rig.reaches(State::active, 350); }

  Rig rig;
};

// A fault came within 81 500 samples while the floor was remembered for 600 of them.
TEST_P(SlowLoop, TakesHoldAndRaisesNoFalseAlarm) {
  ASSERT_TRUE(becomes_active()) << to_text(rig.fault());
  for (int k = 0; k < 100'000 && rig.state() == State::active; ++k) rig.step();
  EXPECT_EQ(rig.state(), State::active) << to_text(rig.fault()) << " in sample " << rig.k();
  EXPECT_EQ(rig.supervisor().n_faults(), 0);
  EXPECT_EQ(rig.supervisor().n_saturated(), 0);
}

TEST_P(SlowLoop, AMissingMeasurementChangesNothing) {
  ASSERT_TRUE(becomes_active());
  for (const int n : {1, 2, 5, 10}) {
    rig.steps(n, toy::nothing);
    EXPECT_EQ(rig.state(), State::active) << n;
    rig.steps(20);
  }
  rig.steps(12, toy::nothing);
  EXPECT_EQ(rig.state(), State::fading);
  EXPECT_TRUE(rig.reaches(State::active, 250));
  EXPECT_EQ(rig.supervisor().n_faults(), 0) << to_text(rig.fault());
}

// A smooth step of n samples has none above 15/8 / n of it.
TEST_P(SlowLoop, NothingEndsInAStep) {
  ASSERT_TRUE(becomes_active());
  rig.steps(1000);
  rig.steps(12, toy::nothing);
  ASSERT_EQ(rig.state(), State::fading);
  const VectorXd held = rig.force();
  ASSERT_GT(worst_of(held), 1);
  rig.largest_jump = 0;
  rig.steps(250, toy::nothing);
  EXPECT_EQ(rig.force(), VectorXd::Zero(4));
  // In 200 samples.
  EXPECT_LE(rig.largest_jump, 1.01 * 15 / 8 / 200 * worst_of(held));
}

INSTANTIATE_TEST_SUITE_P(Rates, SlowLoop, testing::Values(1.0, 10.0, 31.0, 150.0),
                         [](const auto& rate) {
                           return "Of" + std::to_string(std::lround(rate.param)) + "Hz";
                         });

// They hold it for ten samples and fade it in a second: whoever commands before is heard in a step.
TEST(SlowLoops, AmplifiersHaveLetGoBeforeAnyoneCommands) {
  for (const double rate_hz : {1.0, 2.0, 10.0, 29.0, 31.0, 150.0, 1000.0}) {
    Rig rig(default_policy(rate_hz), true, slow_gains(rate_hz));
    rig.floor = floor_of_noise();
    rig.leave(2, 0);
    const int most = static_cast<int>(2 * rate_hz) + 40;
    double acts = 2;
    int k = 0;
    for (; k < most && !rig.sent_any; ++k) {
      acts = worst_of(rig.force());
      rig.step();
    }
    EXPECT_LT(k, most) << rate_hz;
    // No more than one command may change: a tenth of the force limit in a second.
    EXPECT_LE(acts, 20 / std::max(200.0, rate_hz)) << rate_hz << " Hz, sample " << k;
    EXPECT_EQ(rig.fault(), Fault::none);
  }
}

// exp(-n / N) of N commands falls below 1 - 0.25 at n = 0.2877 N.
TEST(SlowLoops, FewCommandsAtTheLimitAreNoFault) {
  for (const double rate_hz : {1.0, 10.0, 200.0, 1000.0}) {
    CommandWatch watch(1, 1 / rate_hz, 10, 0.25);
    const double window = std::max(200.0, rate_hz);
    int n = 0;
    for (; n < 2000 && !watch.limited(); ++n) watch.command(VectorXd::Constant(1, 10), true, -1);
    EXPECT_EQ(n, std::ceil(-std::log(0.75) * window)) << rate_hz;
  }
}

// A tenth of the force limit of 200 N in 200 samples, where no floor is measured that asks for
// less. Who finds more than that on the legs waits until it is gone.
TEST(SlowLoops, ACommandMayAlwaysChangeByAsMuchASample) {
  for (const double rate_hz : {1.0, 20.0, 200.0}) {
    const Gains frame = slow_gains(rate_hz);
    Gains blind = frame;
    blind.plant.B_w.resize(8, 0);
    const auto arms_until = [&](double left) {
      Rig rig(default_policy(rate_hz), true, blind, frame);
      EXPECT_TRUE(rig.reaches(State::ramp_in, 1000, [&](Measurement& m) {
        m.applied.setConstant(left);
        return true;
      })) << rate_hz;
      return rig.k();
    };
    const std::int64_t at_rest = arms_until(0);
    EXPECT_EQ(arms_until(0.09), at_rest) << rate_hz;
    EXPECT_GT(arms_until(0.11), at_rest) << rate_hz;
  }
}

// Changes of which none is too much alone, all one way: they are remembered for as many samples.
TEST(SlowLoops, CommandsThatGoOneWayAreFoundInAsManySamples) {
  const auto found_after = [](double rate_hz) {
    const Gains gains = slow_gains(rate_hz);
    Pace pace(gains, {.free = 1e-3, .ramp_in_s = slowed(1, rate_hz)});
    std::mt19937_64 random(4);
    std::normal_distribution<double> normal;
    pace.restart();
    for (std::int64_t k = 0; k < 100; ++k) {
      pace.listen(k, VectorXd::NullaryExpr(4, [&] { return 1e-3 * normal(random); }));
    }
    pace.begin(VectorXd::Zero(4));
    int n = 0;
    for (; n < 100; ++n) {
      pace.forget(1);
      pace.floor(VectorXd::Constant(1, n < 20 ? 0.1 * normal(random) : 0));
      pace.expect(1, 1, VectorXd::Ones(4));
      // By then the loop has answered the floor.
      const VectorXd change = (n < 40 ? 0 : 0.5) * pace.most(1);
      if (pace.command(1, change) >= 0) break;
    }
    return n;
  };
  const int of_200_hz = found_after(200);
  EXPECT_GT(of_200_hz, 40);
  EXPECT_LT(of_200_hz, 100);
  for (const double rate_hz : {1.0, 20.0}) EXPECT_EQ(found_after(rate_hz), of_200_hz) << rate_hz;
}

// They go as far back as the records, to within the samples between two of them.
TEST(SlowLoops, AFlightRecordHasTheCheckpointsOfItsRecords) {
  for (const double rate_hz : {1.0, 20.0, 200.0, 1000.0}) {
    Policy policy = default_policy(rate_hz);
    policy.record_s = 100 / rate_hz;
    Rig rig(policy, true, slow_gains(rate_hz));
    rig.steps(1000);
    const auto checkpoints = rig.loop().flight().checkpoints();
    const std::int64_t first = rig.loop().flight().records().front()->period;
    const std::int64_t between = checkpoints[1]->period - checkpoints[0]->period;
    EXPECT_LE(std::abs(checkpoints.front()->period - first), between) << rate_hz;
  }
}

}  // namespace
}  // namespace stillframe::controller
