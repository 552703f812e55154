#include <gtest/gtest.h>

#include <limits>

#include "controller/start_check.hpp"
#include "core/numerics/smooth_step.hpp"
#include "core/numerics/worst.hpp"
#include "tests/controller/rig.hpp"

// The state machine and the fault policy, on a clock of its own and with a frame that answers.
namespace stillframe::controller {
namespace {

using Eigen::VectorXd;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
// Quiet 0.35 s, arming 0.5 s, ramp 1 s, and a little.
constexpr int to_active = 1900;

TEST(SmoothStep, IsFlatAtBothEndsAndHasAnInverse) {
  EXPECT_EQ(smooth_step(0), 0);
  EXPECT_EQ(smooth_step(1), 1);
  EXPECT_EQ(smooth_step(-1), 0);
  EXPECT_EQ(smooth_step(2), 1);
  // s = 10 h^3 near 0: velocity and acceleration are zero there.
  EXPECT_NEAR(smooth_step(1e-4), 1e-11, 2e-15);
  for (const double w : {0.0, 1e-9, 0.3, 0.5, 0.999, 1.0}) {
    // To the rounding of s, whose terms reach 15.
    EXPECT_NEAR(smooth_step(smooth_step_inverse(w)), w, 4e-15) << w;
  }
}

TEST(Supervisor, ArmsRampsInAndIsolates) {
  Rig rig;
  EXPECT_EQ(rig.state(), State::idle);
  ASSERT_TRUE(rig.reaches(State::arming, 400));
  EXPECT_EQ(rig.force(), VectorXd::Zero(4));
  ASSERT_TRUE(rig.reaches(State::ramp_in, 600));
  const std::int64_t began = rig.k();
  rig.steps(20);
  const double at_first = rig.force().norm();  // w = s(0.02) = 8e-5
  ASSERT_TRUE(rig.reaches(State::active, 1100));
  EXPECT_NEAR(static_cast<double>(rig.k() - began), 1000, 2);  // ramp_in_s, one sample each way
  EXPECT_LT(at_first, 1e-3 * rig.force().norm());
  rig.peak = 0;
  rig.steps(4000);
  EXPECT_EQ(rig.state(), State::active);
  EXPECT_LT(rig.peak, 0.3 * toy::passive_peak(to_active + 4000));
}

// From 250 Hz, below which the toy with its delay has no stable loop, to 20 kHz, in the same
// seconds.
class SupervisorRates : public testing::TestWithParam<double> {};

TEST_P(SupervisorRates, ArmsRampsHoldsFadesAndComesBack) {
  const Gains gains = toy::damped_gains(5, GetParam());
  ASSERT_LT(closed_loop_radius(gains), 1);
  Rig rig({}, true, gains);
  const auto samples = [&](double seconds) { return static_cast<int>(seconds * GetParam()) + 2; };
  ASSERT_TRUE(rig.reaches(State::active, samples(1.5))) << to_text(rig.fault());
  rig.steps(10, toy::nothing);
  EXPECT_EQ(rig.state(), State::active);
  rig.step(toy::nothing);
  EXPECT_EQ(rig.state(), State::fading);
  EXPECT_TRUE(rig.reaches(State::fault, samples(1), toy::nothing));
  EXPECT_TRUE(rig.reaches(State::active, samples(1.6)));
  EXPECT_EQ(rig.loop().counters().n_late, 0);
  EXPECT_EQ(rig.loop().counters().n_lost, rig.loop().counters().n_missing);
}

INSTANTIATE_TEST_SUITE_P(Hz, SupervisorRates, testing::Values(250, 1000, 5000, 20'000));

TEST(Supervisor, StopRampsOutAndStartComesBack) {
  Rig rig;
  ASSERT_TRUE(rig.reaches(State::active, to_active));
  const double before = rig.force().norm();
  EXPECT_GT(before, 0);
  rig.loop().request(Request::stop);
  rig.step();
  EXPECT_EQ(rig.state(), State::ramp_out);
  ASSERT_TRUE(rig.reaches(State::idle, 1100));
  rig.steps(3);
  EXPECT_EQ(rig.force(), VectorXd::Zero(4));
  rig.steps(500);
  EXPECT_EQ(rig.state(), State::idle);
  rig.loop().request(Request::start);
  EXPECT_TRUE(rig.reaches(State::active, to_active));
  EXPECT_EQ(rig.loop().counters().n_faults, 0);
  EXPECT_EQ(rig.loop().counters().n_rejoins, 0);
}

TEST(Supervisor, WaitsForARequestWhereThePolicySaysSo) {
  Policy policy;
  policy.start_at_once = false;
  Rig rig(policy);
  rig.steps(3000);
  EXPECT_EQ(rig.state(), State::idle);
  rig.loop().request(Request::start);
  EXPECT_TRUE(rig.reaches(State::active, to_active));
}

TEST(Supervisor, PassiveCommandsZeroAndNeverStarts) {
  Rig rig({}, false);
  rig.steps(400);
  rig.loop().request(Request::start);
  rig.steps(2000);
  EXPECT_EQ(rig.state(), State::idle);
  EXPECT_TRUE(rig.sent_any);
  EXPECT_EQ(rig.force(), VectorXd::Zero(4));
}

TEST(Supervisor, HoldsThenFadesThenLetsGoAndComesBack) {
  Rig rig;
  ASSERT_TRUE(rig.reaches(State::active, to_active));
  const VectorXd held = rig.force();
  for (int i = 0; i < 10; ++i) {
    rig.step(toy::nothing);
    EXPECT_FALSE(rig.sent_any);
    EXPECT_EQ(rig.state(), State::active);
  }
  rig.step(toy::nothing);
  EXPECT_EQ(rig.state(), State::fading);
  for (int i = 1; i < 999; ++i) {
    // q falls by a thousandth each period, the first of the fade included; 1e-12: 1000 roundings.
    EXPECT_LT((rig.force() - held * smooth_step(1 - i * 1e-3)).norm(), 1e-12 * held.norm()) << i;
    rig.step(toy::nothing);
    ASSERT_TRUE(rig.sent_any);
  }
  ASSERT_TRUE(rig.reaches(State::fault, 4, toy::nothing));
  EXPECT_EQ(rig.fault(), Fault::silence);
  EXPECT_FALSE(rig.latched());
  rig.steps(3, toy::nothing);
  EXPECT_EQ(rig.force(), VectorXd::Zero(4));
  EXPECT_TRUE(rig.reaches(State::active, 2500));
  EXPECT_EQ(rig.loop().counters().n_rejoins, 1);
}

TEST(Supervisor, ComesBackOutOfAShortFadeWithoutABump) {
  Rig rig, undisturbed;
  ASSERT_TRUE(rig.reaches(State::active, to_active));
  ASSERT_TRUE(undisturbed.reaches(State::active, to_active));
  rig.steps(50, toy::nothing);
  EXPECT_EQ(rig.state(), State::fading);
  rig.largest_jump = undisturbed.largest_jump = 0;
  rig.step();
  undisturbed.steps(51);
  EXPECT_EQ(rig.state(), State::ramp_in);
  ASSERT_TRUE(rig.reaches(State::active, 1000));
  EXPECT_EQ(rig.loop().counters().n_faults, 0);
  // The force makes up for what the floor has done meanwhile, as in a ramp; a jump to zero or back
  // would be its whole size.
  EXPECT_LT(rig.largest_jump, 0.3 * worst_of(rig.force()) + undisturbed.largest_jump);
}

TEST(Supervisor, CommandsThatAreLostAreAFaultThatPassesWithoutABump) {
  for (const int lost : {5, 50, 95, 130, 300, 700, 1500}) {
    SCOPED_TRACE(lost);
    Rig rig;
    ASSERT_TRUE(rig.reaches(State::active, 3000));
    double largest_change = 0;
    const auto step = [&] {
      const Eigen::VectorXd before = rig.force();
      rig.step();
      largest_change = worst_of(largest_change, worst_of(rig.force() - before));
    };
    for (int i = 0; i < 1000; ++i) step();
    const double of_the_loop = largest_change;
    rig.deaf = true;
    for (int i = 0; i < lost; ++i) step();
    rig.deaf = false;
    for (int i = 0; i < 4000; ++i) step();
    EXPECT_EQ(rig.state(), State::active);
    // The amplifiers hold for ten samples, and a hundred are ridden out.
    EXPECT_EQ(rig.fault(), lost > 111 ? Fault::unheard : Fault::none);
    // What the frame swings with when the amplifiers let go of it comes to that of one that was
    // never held: a tenth at most, as docs/safety.md allows.
    EXPECT_LE(rig.peak, 1.1 * toy::passive_peak(static_cast<int>(rig.k())));
    if (lost <= 111) continue;
    // Back again it ramps in, on a frame that swings further than one that is held.
    EXPECT_LT(largest_change, 2 * of_the_loop);
  }
}

TEST(Supervisor, OneBadSampleIsAMissedOne) {
  for (const double bad : {not_a_number, 1e9}) {
    Rig rig;
    ASSERT_TRUE(rig.reaches(State::active, to_active));
    rig.step([&](Measurement& m) {
      m.sigma(2) = bad;
      return true;
    });
    EXPECT_FALSE(rig.sent_any);
    rig.step();
    EXPECT_TRUE(rig.sent_any);
    EXPECT_EQ(rig.state(), State::active);
    EXPECT_EQ(rig.loop().counters().n_missing, 1);
  }
}

TEST(Supervisor, BadSamplesThatStayAreALatchedFault) {
  const std::vector<std::pair<double, Fault>> cases{{not_a_number, Fault::not_finite},
                                                    {1e9, Fault::out_of_range}};
  for (const auto& [bad, fault] : cases) {
    Rig rig;
    ASSERT_TRUE(rig.reaches(State::active, to_active));
    const auto wire = [bad](Measurement& m) {
      m.sigma(2) = bad;
      return true;
    };
    ASSERT_TRUE(rig.reaches(State::fault, 1100, wire));
    EXPECT_EQ(rig.fault(), fault);
    EXPECT_TRUE(rig.latched());
    // Good measurements do not mend it, nor does a start; a reset and a start do.
    rig.steps(1500);
    rig.loop().request(Request::start);
    rig.steps(1500);
    EXPECT_EQ(rig.state(), State::fault);
    rig.loop().request(Request::reset);
    rig.steps(2);
    EXPECT_EQ(rig.state(), State::idle);
    rig.steps(1000);
    EXPECT_EQ(rig.state(), State::idle);
    rig.loop().request(Request::start);
    EXPECT_TRUE(rig.reaches(State::active, to_active));
  }
}

TEST(Supervisor, AFrozenSensorIsALatchedFault) {
  Rig rig;
  ASSERT_TRUE(rig.reaches(State::active, to_active));
  double value = 0;
  bool first = true;
  const auto freeze = [&](Measurement& m) {
    if (first) value = m.sigma(1);
    first = false;
    m.sigma(1) = value;
    return true;
  };
  ASSERT_TRUE(rig.reaches(State::fault, 300, freeze));
  EXPECT_EQ(rig.fault(), Fault::restless);
  EXPECT_TRUE(rig.latched());
  rig.steps(3000, freeze);
  // A frozen sensor is positive feedback to the law.
  EXPECT_LT(rig.peak, toy::passive_peak(to_active + 3300));
}

// A sensor of the wrong sign is positive feedback to the law: the loop runs away to its limit.
TEST(Supervisor, ALoopThatLivesAtItsLimitIsALatchedFault) {
  Policy policy;
  policy.force_limit_n = 50;
  policy.free_rate_n_per_s = 1e12;  // as if the floor were not what it runs away from
  Rig rig(policy);
  ASSERT_TRUE(rig.reaches(State::active, to_active));
  const auto reversed = [](Measurement& m) {
    m.sigma(1) = -m.sigma(1);
    return true;
  };
  ASSERT_TRUE(rig.reaches(State::fault, 3000, reversed));
  EXPECT_EQ(rig.fault(), Fault::limited);
  EXPECT_TRUE(rig.latched());
  EXPECT_LE(rig.largest_force, 50);
  rig.steps(1100, reversed);
  EXPECT_EQ(rig.force(), VectorXd::Zero(4));
}

TEST(Supervisor, WhatIsBrokenStaysBrokenWhenTheLastSampleIsOnlyMissing) {
  Rig rig;
  ASSERT_TRUE(rig.reaches(State::active, to_active));
  int n = 0;
  ASSERT_TRUE(rig.reaches(State::fault, 1100, [&](Measurement& m) {
    m.sigma(0) = not_a_number;
    return ++n % 3 == 0;
  }));
  EXPECT_EQ(rig.fault(), Fault::not_finite);
  EXPECT_TRUE(rig.latched());
}

TEST(Supervisor, HalfOfAllMeasurementsLostStaysActiveNineOfTenDoesNot) {
  std::mt19937_64 random(3);
  for (const double lost : {0.5, 0.9}) {
    Rig rig;
    ASSERT_TRUE(rig.reaches(State::active, to_active));
    std::bernoulli_distribution loses(lost);
    const auto wire = [&](Measurement&) { return !loses(random); };
    rig.steps(8000, wire);
    if (lost < 0.6) {
      EXPECT_EQ(rig.loop().counters().n_faults, 0);
    } else {
      EXPECT_EQ(rig.fault(), Fault::losses);
      EXPECT_FALSE(rig.latched());
      // Gaps of more than hold_periods, again and again, do not keep the fade from its end.
      EXPECT_EQ(rig.force(), VectorXd::Zero(4));
    }
  }
}

TEST(Supervisor, AfterASleepOfItsOwnItListensFirst) {
  Rig rig;
  ASSERT_TRUE(rig.reaches(State::active, to_active));
  rig.steps(40, {}, false);
  rig.step();
  EXPECT_EQ(rig.state(), State::fault);
  EXPECT_EQ(rig.fault(), Fault::suspended);
  EXPECT_EQ(rig.loop().counters().n_late, 40);
  // Until the amplifiers have let go of what it held.
  for (int i = 0; i < 1490; ++i) {
    EXPECT_FALSE(rig.sent_any);
    rig.step();
  }
  EXPECT_TRUE(rig.reaches(State::active, 4000));
  EXPECT_EQ(rig.loop().counters().n_rejoins, 1);
}

// What another controller has left, within the force limit or beyond it, is the amplifiers' to let
// go of: no force of this loop until they have, and no step on the way.
TEST(Supervisor, WaitsUntilTheAmplifiersHaveLetGo) {
  Policy policy;
  policy.force_limit_n = 3;
  for (const double left : {0.5, 2.0, 4.0, 50.0, -30.0}) {
    Rig rig(policy);
    rig.leave(left);
    VectorXd before = rig.force();
    double largest_change = 0;
    int first_sent = -1;
    for (int k = 0; k < 1490; ++k) {  // then the ramp may begin
      rig.step();
      largest_change = worst_of(largest_change, worst_of(rig.force() - before));
      before = rig.force();
      if (rig.sent_any && first_sent < 0) first_sent = k;
    }
    EXPECT_GT(first_sent, 980) << left;  // their fade in 1 s, but for what is harmless of it
    // The steepest part of their fade.
    EXPECT_LT(largest_change, std::abs(left) * 15.0 / 8 * 1e-3 * 1.001) << left;
    // A frame that was let go of more swings harder than 3 N can hold.
    if (std::abs(left) > 10) continue;
    EXPECT_TRUE(rig.reaches(State::active, 2500)) << left;
    EXPECT_EQ(rig.fault(), Fault::none) << left;
  }
}

TEST(Supervisor, ListensFromTheFirstMeasurementOn) {
  Rig rig;
  rig.steps(2000, toy::nothing);
  rig.leave(2);
  const std::int64_t began = rig.k();
  while (!rig.sent_any && rig.k() < began + 3000) rig.step();
  EXPECT_GT(rig.k() - began, 980);
}

// Another controller may have come while it slept: it listens, whatever it was doing, until it has
// held its peace for as long as one that has just come.
TEST(Supervisor, WhoSleptListensFirst) {
  for (const bool active : {false, true}) {
    Rig rig({}, active);
    rig.steps(active ? 2500 : 500);
    ASSERT_EQ(rig.state(), active ? State::active : State::idle);
    ASSERT_TRUE(rig.sent_any);
    rig.steps(50, {}, false);
    // 0.35 s where nothing is held, and 1.5 s where the amplifiers have something to let go of.
    for (int k = 0; k < (active ? 1490 : 340); ++k) {
      rig.step();
      ASSERT_FALSE(rig.sent_any) << active << " " << k;
    }
    rig.steps(20);
    EXPECT_TRUE(rig.sent_any) << active;
  }
}

// Said by a read-back, and held by nothing: a person should look.
TEST(Supervisor, AForceBeyondTheLimitThatStaysIsALatchedFault) {
  Policy policy;
  policy.force_limit_n = 3;
  Rig rig(policy);
  const auto stuck = [](Measurement& m) {
    m.applied(1) = 50'000;
    return m.seq % 7 != 0;
  };
  ASSERT_TRUE(rig.reaches(State::fault, 2200, stuck));
  EXPECT_EQ(rig.fault(), Fault::out_of_range);
  EXPECT_TRUE(rig.latched());
  rig.steps(500, stuck);
  EXPECT_EQ(rig.largest_force, 0);
  rig.loop().request(Request::reset);
  rig.steps(2);
  rig.loop().request(Request::start);
  EXPECT_TRUE(rig.reaches(State::active, to_active));
}

// A read-back that lies, whatever else is lost: a frame that is let go of gets no force.
TEST(Supervisor, NothingIsCommandedOnTheWordOfAReadBack) {
  for (const char* state : {"latched", "idle", "passive"}) {
    for (const bool asleep : {false, true}) {
      SCOPED_TRACE(std::string(state) + (asleep ? ", asleep" : ", lost"));
      Rig rig({}, state != std::string("passive"));
      if (state != std::string("passive")) {
        ASSERT_TRUE(rig.reaches(State::active, to_active));
        rig.loop().request(Request::stop);
        ASSERT_TRUE(rig.reaches(State::idle, 1100));
      }
      if (state == std::string("latched")) {
        rig.loop().request(Request::start);
        rig.steps(1700, [](Measurement& m) {
          m.sigma(0) = 0;
          return true;
        });
        ASSERT_TRUE(rig.latched());
      }
      rig.steps(1500);
      rig.largest_force = 0;
      bool missing = false;
      const auto lie = [&](Measurement& m) {
        m.applied(0) = 150;
        return !missing || asleep;
      };
      for (int burst = 0; burst < 3; ++burst) {
        missing = true;
        rig.steps(15, lie, !asleep);
        missing = false;
        rig.steps(2000, lie);
      }
      EXPECT_EQ(rig.largest_force, 0);
    }
  }
}

// Nor is a force that fades taken away in one step by a read-back that breaks in a gap.
TEST(Supervisor, AFadeGoesOnWhateverAReadBackSays) {
  for (const double says : {0.0, 150.0}) {
    Rig rig, sound;
    for (Rig* each : {&rig, &sound}) {
      ASSERT_TRUE(each->reaches(State::active, to_active));
      each->steps(130, toy::nothing);
      EXPECT_EQ(each->state(), State::fading);
    }
    const auto lie = [&](Measurement& m) {
      m.applied(0) = says;
      return true;
    };
    for (int k = 0; k < 1000; ++k) {
      rig.step(lie);
      sound.step();
      ASSERT_EQ(rig.force(), sound.force()) << says << " " << k;
    }
  }
}

// They have begun to let go themselves, by an amount that nobody knows for sure.
TEST(Supervisor, AmplifiersThatDidNotHearItAreLeftAlone) {
  Rig rig;
  ASSERT_TRUE(rig.reaches(State::active, to_active));
  rig.deaf = true;
  rig.steps(300, toy::nothing);
  VectorXd before = rig.force();
  double largest_change = 0;
  const double steepest = 15.0 / 8 * 1e-3 * worst_of(before);
  rig.deaf = false;
  rig.step();
  for (int k = 0; k < 1400; ++k) {
    EXPECT_FALSE(rig.sent_any) << k;
    rig.step();
    largest_change = worst_of(largest_change, worst_of(rig.force() - before));
    before = rig.force();
  }
  // Of all of the force, of which the fade has taken some already.
  EXPECT_LT(largest_change, 2 * steepest);
  EXPECT_TRUE(rig.reaches(State::active, 2500));
}

TEST(Supervisor, RejoinsOnlySoOftenAMinute) {
  Policy policy;
  policy.rejoins_a_minute = 2;
  policy.arming_s = 0.05;
  policy.fade_s = policy.ramp_in_s = 0.05;
  Rig rig(policy);
  ASSERT_TRUE(rig.reaches(State::active, to_active));
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(rig.reaches(State::fault, 200, toy::nothing)) << i;
    ASSERT_TRUE(rig.reaches(State::active, to_active)) << i;
  }
  ASSERT_TRUE(rig.reaches(State::fault, 200, toy::nothing));
  rig.steps(1000);
  EXPECT_EQ(rig.state(), State::fault);
  EXPECT_TRUE(rig.latched());
}

TEST(Supervisor, ALawThatOverflowsIsLetGo) {
  Policy policy;
  policy.sigma_limit_n = 1e308;
  policy.offset_limit_n = 1e308;
  Rig rig(policy);
  ASSERT_TRUE(rig.reaches(State::active, to_active));
  rig.steps(3, [](Measurement& m) {
    m.sigma.setConstant(9e307);
    return true;
  });
  EXPECT_EQ(rig.state(), State::fault);
  EXPECT_EQ(rig.fault(), Fault::law_not_finite);
  EXPECT_TRUE(rig.force().allFinite());
  EXPECT_TRUE(rig.latched());
  rig.steps(1100);
  rig.loop().request(Request::reset);
  rig.step();
  rig.loop().request(Request::start);
  EXPECT_TRUE(rig.reaches(State::active, to_active));
}

TEST(Supervisor, MemoryIsAllThatCounts) {
  Policy policy;
  policy.rate_limit_n_per_s = 50;
  std::mt19937_64 random(5);
  std::bernoulli_distribution loses(0.4);
  const Gains gains = toy::gains(5);
  policy.force_limit_n = 3;
  policy.limited_part = 1;  // what is measured here has nothing to do with the forces
  policy.excitation = {
      .kind = ExcitationPlan::Kind::multisine, .force_n = 1e-3, .window_s = 0.5, .windows = 2};
  Supervisor one(gains, policy, true), other = one;
  std::vector<double> memory(one.memory_size());
  Command a, b;
  a.force = b.force = VectorXd::Zero(4);
  Measurement m;
  m.sigma = m.applied = VectorXd::Zero(4);
  std::normal_distribution<double> normal;
  int changed = 0;
  for (int k = 0; k < 8000; ++k) {
    if (k % 97 == 0) {
      // From here on the other has nothing but the memory of the first.
      one.save(memory);
      other = Supervisor(gains, policy, true);
      other.restore(memory);
    }
    m.seq = k;
    m.time_ns = k * 1'000'000LL;
    // About an offset of 3 N, which arming takes out.
    m.sigma = m.sigma.unaryExpr([&](double x) { return 0.9 * x + 0.3 + 0.01 * normal(random); });
    m.applied = a.force;
    const bool silent = k > 5000 && k < 6300;
    const bool have = !silent && !loses(random);
    const Event event{.n_elapsed = 1, .measurement = have ? &m : nullptr};
    const State before = one.state();
    ASSERT_EQ(one.step(event, a), other.step(event, b)) << k;
    ASSERT_EQ(a.force, b.force) << k;
    ASSERT_EQ(a.seq, b.seq);
    ASSERT_EQ(one.state(), other.state());
    changed += before != one.state();
  }
  EXPECT_GT(changed, 6);  // arming, ramp, active, fading, fault and back again
}

}  // namespace
}  // namespace stillframe::controller
