#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "controller/pace.hpp"
#include "controller/start_check.hpp"
#include "core/numerics/worst.hpp"
#include "tests/controller/made_up_floor.hpp"
#include "tests/controller/rig.hpp"

// What a loop may hurry, and that a sound one never does.
namespace stillframe::controller {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Quick to the active state; nothing but the pace in the way of a linear loop.
Policy quick() {
  Policy policy;
  policy.ramp_in_s = 0.05;
  policy.arming_s = 0.2;
  policy.require_motion = false;
  policy.force_limit_n = policy.sigma_limit_n = 1e9;
  policy.free_rate_n_per_s = 1e12;
  return policy;
}

/// Of any legal design: delays, leads, roll-offs, rates and targets.
Gains random_gains(std::mt19937_64& random) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Gains gains = toy::damped_gains(uniform(4, 8), std::pow(10, uniform(2.9, 3.7)));
  gains.delay_samples = uniform(0, 1) < 0.5 ? 1 : uniform(0.3, 1.2);
  gains.lead_samples = gains.delay_samples + 0.5;
  if (uniform(0, 1) < 0.5) {
    gains.roll_off_hz = gains.sample_rate_hz / uniform(6, 12);
    gains.lead_samples += gains.sample_rate_hz / (two_pi * *gains.roll_off_hz);
  }
  // From a loop that rings to one that does not.
  const double damping_ratio = uniform(0.1, 1);
  gains.K_I *= damping_ratio / toy::damping_ratio;
  gains.force_limit_n = 1e9;
  return gains;
}

bool is_stable(const Gains& gains) { return closed_loop_radius(gains) < 1 - 1e-6; }

// The two ways to L and N: the design's matrices, and the loop itself on the bench, kicked once.
TEST(Pace, IsWhatOneKickDoesToTheCommands) {
  std::mt19937_64 random(3);
  int n_trials = 0;
  for (int trial = 0; trial < 8; ++trial) {
    Gains gains = random_gains(random);
    if (!is_stable(gains)) continue;
    const Pace pace(gains, {});
    const auto changes = [&](Index sensor, double seconds) {
      const auto n = static_cast<int>(seconds * gains.sample_rate_hz);
      Rig rig(quick(), true, gains);
      rig.floor = [](std::int64_t, VectorXd& w) { w.setZero(); };
      EXPECT_TRUE(rig.reaches(State::active, static_cast<int>(2 * gains.sample_rate_hz)));
      const std::int64_t kick = rig.k();
      rig.floor = [&](std::int64_t k, VectorXd& w) { w.setConstant(sensor < 0 && k == kick); };
      VectorXd sums = VectorXd::Zero(4), last = rig.force();
      const auto wire = [&](Measurement& m) {
        if (sensor >= 0 && m.seq == kick) m.sigma(sensor) += 1;
        return true;
      };
      for (int k = 0; k < n; ++k) {
        rig.step(wire);
        const VectorXd change = rig.force() - last;
        last = rig.force();
        sums += sensor < 0 ? VectorXd(change.cwiseAbs()) : VectorXd(change.cwiseAbs2());
      }
      return sums;
    };
    // The design is followed for half a second at least, and then until it no longer swings.
    const auto between = [&](const VectorXd& L, Index sensor) {
      const VectorXd least = changes(sensor, 0.499), most = changes(sensor, 4);
      const double rounding = 1e-9 * most.maxCoeff();
      EXPECT_TRUE((L.array() > 0.999 * least.array() - rounding).all()) << trial;
      EXPECT_TRUE((L.array() < 1.001 * most.array() + rounding).all()) << trial;
    };
    between(pace.per_floor().col(0), -1);
    for (Index sensor = 0; sensor < 4; ++sensor) between(pace.per_noise().col(sensor), sensor);
    ++n_trials;
  }
  EXPECT_GT(n_trials, 5);
}

// The worst floor there is, turned so that all changes of one leg add up, reaches the pace and does
// not exceed it; nor does anything else that a floor may do.
TEST(Pace, NoFloorMakesASoundLoopHurry) {
  std::mt19937_64 random(5);
  double nearest = 0;
  int n_trials = 0;
  for (int trial = 0; trial < 12; ++trial) {
    const Gains gains = random_gains(random);
    if (!is_stable(gains)) continue;
    const Pace pace(gains, {});
    Policy policy = quick();
    policy.free_rate_n_per_s = 1e-9;
    policy.ramp_in_s = 1;
    const auto n = static_cast<int>(0.5 * gains.sample_rate_hz);
    // Response of the changes to one kick, leg by leg.
    Eigen::MatrixXd response(4, n);
    {
      Rig rig(quick(), true, gains);
      rig.floor = [](std::int64_t, VectorXd& w) { w.setZero(); };
      EXPECT_TRUE(rig.reaches(State::active, 4 * n));
      const std::int64_t kick = rig.k();
      rig.floor = [&](std::int64_t k, VectorXd& w) { w.setConstant(k == kick); };
      VectorXd last = rig.force();
      for (int k = 0; k < n; ++k) {
        rig.step();
        response.col(k) = rig.force() - last;
        last = rig.force();
      }
    }
    const Index leg = trial % 4;
    const double size = std::pow(10.0, trial % 5 - 5);
    Rig rig(policy, true, gains);
    const auto worst = [&](std::int64_t k) {
      // Half a second in three, and back again: a floor comes to rest where it was.
      if (k % (6 * n) >= n) return 0.0;
      const double way = k / (6 * n) % 2 == 0 ? size : -size;
      return response(leg, n - 1 - static_cast<Index>(k % (6 * n))) > 0 ? way : -way;
    };
    // While arming a floor that is accelerated for ever is an offset of the sensors.
    rig.floor = [](std::int64_t, VectorXd& w) { w.setZero(); };
    ASSERT_TRUE(rig.reaches(State::active, 8 * n)) << to_text(rig.fault());
    rig.floor = [&](std::int64_t k, VectorXd& w) { w.setConstant(worst(k)); };
    double last = 0;
    for (int k = 0; k < 18 * n; ++k) {
      rig.step();
      const double change = std::abs(rig.force()(leg) - std::exchange(last, rig.force()(leg)));
      nearest = worst_of(nearest, change / (size * pace.per_floor()(leg, 0)));
    }
    // From a quiet floor to one a thousand times as loud within a sample, and back.
    std::normal_distribution<double> normal;
    rig.floor = [&](std::int64_t k, VectorXd& w) {
      w.setConstant((k / n % 2 == 0 ? 1 : 1000) * size * normal(random));
    };
    rig.steps(20 * n);
    // A floor that jumps a thousandfold is believed from its second sample on.
    EXPECT_LE(rig.supervisor().n_saturated(), 5) << trial;
    EXPECT_EQ(rig.supervisor().n_faults(), 0) << trial;
    ++n_trials;
  }
  EXPECT_GT(n_trials, 8);
  // A floor that is made for it takes all that is allowed.
  EXPECT_GT(nearest, 0.99);
  EXPECT_LE(nearest, 1.01);
}

// Floors that go on, at the frequency to which the loop answers most.
TEST(Pace, ASteadyFloorMakesNoSoundLoopHurry) {
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 12; ++trial) {
    const Gains gains = random_gains(random);
    if (!is_stable(gains)) continue;
    Policy policy = quick();
    policy.free_rate_n_per_s = 1e-9;
    policy.ramp_in_s = 1;
    Rig rig(policy, true, gains);
    const double hz = std::uniform_real_distribution<double>(2, 12)(random);
    const auto floor = [&](std::int64_t k, VectorXd& w) {
      const double t = static_cast<double>(k) * gains.sample_time();
      w.setConstant(std::min(0.01 * t, 0.1) * std::sin(two_pi * hz * t));
    };
    rig.floor = floor;
    const auto n = static_cast<int>(gains.sample_rate_hz);
    ASSERT_TRUE(rig.reaches(State::active, 4 * n)) << to_text(rig.fault());
    rig.steps(25 * n);
    EXPECT_EQ(rig.supervisor().n_faults(), 0) << trial << ", " << hz << " Hz";
    EXPECT_EQ(rig.supervisor().n_saturated(), 0) << trial << ", " << hz << " Hz";
  }
}

// A loop that rings for seconds, on a floor that makes it: its response is followed until it is
// over.
TEST(Pace, ALoopThatRingsIsFollowedToTheEnd) {
  Gains gains = toy::damped_gains();
  gains.K_I *= 0.03 / toy::damping_ratio;
  ASSERT_TRUE(is_stable(gains));
  Policy policy = quick();
  policy.free_rate_n_per_s = 1e-9;
  policy.ramp_in_s = 1;
  Rig rig(policy, true, gains);
  rig.floor = [&](std::int64_t k, VectorXd& w) {
    const double t = 1e-3 * static_cast<double>(k);
    w.setConstant(std::min(0.001 * t, 0.02) * std::sin(two_pi * 5 * t));
  };
  ASSERT_TRUE(rig.reaches(State::active, 4000)) << to_text(rig.fault());
  rig.steps(30'000);
  EXPECT_EQ(rig.supervisor().n_faults(), 0) << to_text(rig.fault());
  EXPECT_EQ(rig.supervisor().n_saturated(), 0);
}

// Where every other sample is lost no noise is known, and none is taken for zero.
TEST(Pace, RegularLossesAreNoFault) {
  for (const int every : {2, 3, 5}) {
    Rig rig;
    std::mt19937_64 random(8);
    std::normal_distribution<double> normal;
    int n = 0;
    const auto wire = [&](Measurement& m) {
      for (double& value : m.sigma) value += 0.1 * normal(random);
      return ++n % every != 0;
    };
    ASSERT_TRUE(rig.reaches(State::active, 6000, wire)) << every << " " << to_text(rig.fault());
    rig.steps(5000, wire);
    EXPECT_EQ(rig.supervisor().n_faults(), 0) << every << " " << to_text(rig.fault());
    // And what breaks then is found by its pace.
    const auto broken = [&](Measurement& m) {
      m.sigma(1) = -m.sigma(1);
      return wire(m);
    };
    ASSERT_TRUE(rig.reaches(State::fault, 3000, broken)) << every;
    EXPECT_EQ(rig.fault(), Fault::restless) << every;
  }
}

// One bad value of a floor channel opens nothing, and one that no floor has is no measurement.
TEST(Pace, OneBadSampleOfTheFloorIsNotBelieved) {
  Rig rig;
  bool bad = false;
  double value = 900;
  const auto wire = [&](Measurement& m) {
    if (std::exchange(bad, false)) m.floor.setConstant(value);
    return true;
  };
  ASSERT_TRUE(rig.reaches(State::active, 3000, wire));
  bad = true;
  rig.steps(100, wire);
  value = 1e30;
  bad = true;
  rig.steps(100, wire);
  EXPECT_EQ(rig.loop().counters().n_missing, 1);
  ASSERT_EQ(rig.state(), State::active);
  rig.largest_jump = 0;
  ASSERT_TRUE(rig.reaches(State::fault, 3000, [&](Measurement& m) {
    m.sigma(1) = -m.sigma(1);
    return true;
  }));
  EXPECT_EQ(rig.fault(), Fault::restless);
  EXPECT_LT(rig.largest_jump, 10);
}

// Without a measured floor the pace is that of the swing before; a loop that breaks meets it too.
TEST(Pace, WithoutAFloorItIsThatOfTheFrame) {
  Gains blind = toy::damped_gains();
  blind.plant.B_w.resize(8, 0);
  Rig rig({}, true, blind, toy::damped_gains());
  ASSERT_TRUE(rig.reaches(State::active, 3000)) << to_text(rig.fault());
  rig.steps(5000);
  EXPECT_EQ(rig.supervisor().n_faults(), 0) << to_text(rig.fault());
  ASSERT_TRUE(rig.reaches(State::fault, 3000, [](Measurement& m) {
    m.sigma(1) = -m.sigma(1);
    return true;
  }));
  EXPECT_EQ(rig.fault(), Fault::restless);
}

// What a floor strains by its position, as it does a frame under its weight or with more legs than
// motions, is asked of a loop as well: it is followed, and a floor that grows after arming is no
// fault. Without it, as before, it is one.
TEST(Pace, AFloorThatActsByItsPositionIsFollowed) {
  const Gains gains = toy::damped_gains(), places = toy::by_position(gains);
  Gains blind = places;
  blind.plant.B_w.resize(8, 0);
  blind.plant.A_w.resize(0, 0);
  blind.plant.C_w.resize(0, 0);
  const auto fades_in = [&](Rig& rig) {
    rig.floor = [&, floor = MadeUpFloor(1000, 3)](std::int64_t k, VectorXd& w) mutable {
      floor(5e-2 * smooth_step(std::min(1.0, 2.5e-4 * static_cast<double>(k))), w);
    };
    rig.steps(10'000);
  };
  Rig by_acceleration({}, true, gains), known({}, true, places), unknown({}, true, blind, places);
  for (Rig* rig : {&by_acceleration, &known, &unknown}) fades_in(*rig);
  // One and the same frame; the position is the sum of the sum of 10^4 accelerations.
  EXPECT_LT((known.sigma - by_acceleration.sigma).norm(), 1e-6 * known.peak);
  EXPECT_EQ(known.state(), State::active) << to_text(known.fault());
  EXPECT_EQ(known.supervisor().n_faults(), 0);
  EXPECT_EQ(known.supervisor().n_saturated(), 0);
  EXPECT_EQ(unknown.fault(), Fault::restless);
  // And what breaks is found as soon.
  for (Rig* rig : {&by_acceleration, &known}) {
    const std::int64_t since = rig->k();
    ASSERT_TRUE(rig->reaches(State::fault, 3000, [](Measurement& m) {
      m.sigma(1) = -m.sigma(1);
      return true;
    }));
    EXPECT_EQ(rig->fault(), Fault::restless);
    EXPECT_LT(rig->k() - since, 50);
  }
}

// One leg that swings while the others hardly do, as of a frame with something loose on it, is no
// broken sensor; the same as noise is.
TEST(Pace, ALegThatSwingsAloneIsNotNoisy) {
  const Gains gains = toy::damped_gains();
  Pace pace(gains, {});
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const auto noisy_leg = [&](double swing, double periods_a_sample, double noise) {
    pace.restart();
    for (std::int64_t k = 0; k < 500; ++k) {
      VectorXd sigma(gains.n_legs());
      for (double& value : sigma) value = 1e-3 * normal(random);
      sigma(1) += swing * std::sin(two_pi * periods_a_sample * static_cast<double>(k)) +
                  noise * normal(random);
      pace.listen(k, sigma);
    }
    pace.begin(VectorXd::Zero(gains.n_legs()));
    return pace.noisy();
  };
  for (const double periods_a_sample : {0.001, 0.01, 0.05, 0.1, 0.15, 0.2, 0.24}) {
    EXPECT_EQ(noisy_leg(1, periods_a_sample, 0), -1) << periods_a_sample;
    // The swing hides it only in part.
    EXPECT_EQ(noisy_leg(0.1, periods_a_sample, 0.1), 1) << periods_a_sample;
  }
  EXPECT_EQ(noisy_leg(0, 0, 1), 1);
  EXPECT_EQ(noisy_leg(0, 0, 5e-3), -1);
}

// What the share of the law's force changes, a known curve of a known force, is no haste of the
// loop's: neither where it lets go of a force that it holds, nor where it takes hold again.
TEST(Pace, ToLetGoOfAForceThatIsHeldIsNoHaste) {
  for (const int seed : {1, 2, 3}) {
    Rig rig;
    rig.floor = [floor = MadeUpFloor(1000, seed)](std::int64_t, VectorXd& w) mutable {
      floor(0.05, w);
    };
    double drift = 0;
    const auto wire = [&](Measurement& m) {
      m.sigma(1) += drift;
      return true;
    };
    ASSERT_TRUE(rig.reaches(State::active, 3000, wire)) << to_text(rig.fault());
    for (int k = 0; k < 25'000; ++k) {
      drift = 0.005 * std::min(1.0, k / 10'000.0);
      rig.step(wire);
    }
    ASSERT_EQ(rig.state(), State::active) << to_text(rig.fault());
    EXPECT_GT(std::abs(rig.force()(1)), 5);
    rig.loop().request(Request::stop);
    rig.steps(500, wire);
    rig.loop().request(Request::start);
    rig.steps(2000, wire);
    EXPECT_EQ(rig.state(), State::active) << to_text(rig.fault());
    rig.loop().request(Request::stop);
    rig.steps(3000, wire);
    EXPECT_EQ(rig.state(), State::idle) << to_text(rig.fault());
    EXPECT_EQ(rig.supervisor().n_faults(), 0);
    EXPECT_EQ(rig.supervisor().n_saturated(), 0);
  }
}

}  // namespace
}  // namespace stillframe::controller
