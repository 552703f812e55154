#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <functional>
#include <random>

#include "controller/obedience.hpp"
#include "core/systems/bouc_wen.hpp"
#include "tests/controller/rig.hpp"

// Whether the forces that are said to act are those that were commanded.
namespace stillframe::controller {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index m = 4;

/// What amplifiers and their read-backs make of commands, leg by leg and sample by sample.
struct Way {
  double gain = 1, noise = 0, step = 0, offset = 0, drift = 0, lost = 0, lag_hz = 0;
  double hysteresis = 0;  ///< width of the loop between minus and plus 200 N
  int late = 1;           ///< samples, and one more every now and then
};

/// Forces that swing at 1 to 20 Hz with a size of some newtons that comes and goes, at 1 kHz for
/// so many seconds, go a sound way; from a second before the end on `broken` is done to what leg 1
/// reports. Answers how many samples after that it was found, -1: never.
int found_after(const Way& way, double seconds, std::uint64_t seed,
                const std::function<double(double)>& broken = {}) {
  Gains gains = toy::damped_gains();
  gains.instruments.actuator_lag_hz = way.lag_hz;
  Obedience obedience(gains, Policy{}.disobeyed_part);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const BoucWen loop =
      way.hysteresis > 0 ? bouc_wen({.width = way.hysteresis, .swing_n = 200, .saturation_n = 1000})
                         : BoucWen{};
  VectorXd force = VectorXd::Zero(m), lagged = force, h = force, before = force, acting = force;
  std::deque<VectorXd> under_way(static_cast<std::size_t>(way.late) + 2, force);
  double t = 0;
  const auto read = [&] {
    VectorXd applied = lagged;
    for (Index i = 0; i < m; ++i) {
      if (way.hysteresis > 0) {
        h(i) = loop.moved(h(i), lagged(i) - before(i));
        applied(i) = loop.kappa * lagged(i) - h(i);
      }
      double& value = applied(i);
      value = way.gain * value + way.offset + way.drift * t + way.noise * normal(random);
      if (way.step > 0) value = way.step * std::round(value / way.step);
    }
    before = lagged;
    return applied;
  };
  for (int k = 0; k < 500; ++k, t += 1e-3) obedience.listen(read());
  obedience.begin();
  const int n = static_cast<int>(1000 * seconds);
  std::int64_t elapsed = 1;
  for (int k = 0; k < n; ++k, t += 1e-3) {
    for (Index i = 0; i < m; ++i) {
      const double leg = 1 + 0.1 * static_cast<double>(i);
      const double size = 3 * std::min(1.0, 1e-3 * k) * (1.2 + std::sin(0.5 * leg * t));
      force(i) = size * (std::sin(2 * M_PI * leg * t) + 0.3 * std::sin(2 * M_PI * 20 * leg * t));
    }
    obedience.command(force);
    if (!(uniform(random) < way.lost)) acting = force;
    under_way.push_back(acting);
    under_way.pop_front();
    const std::size_t at = uniform(random) < 0.01 ? 0 : 1;
    const double left = way.lag_hz > 0 ? std::exp(-2 * M_PI * way.lag_hz * gains.sample_time()) : 0;
    lagged = left * lagged + (1 - left) * under_way[at];
    VectorXd applied = read();
    const bool is_broken = broken && k >= n - 1000;
    if (is_broken) applied(1) = broken(applied(1));
    if (uniform(random) < way.lost) {
      ++elapsed;
      continue;
    }
    obedience.hear(elapsed, applied);
    elapsed = 1;
    if (!obedience.is_broken()) continue;
    EXPECT_EQ(obedience.leg() == 1, is_broken) << k;
    return k - (n - 1000);
  }
  return -1;
}

const Way sound[] = {
    {},
    {.gain = 1.02},
    {.gain = 0.98, .noise = 0.01},
    {.noise = 0.05, .lost = 0.1},
    {.step = 0.1},
    {.gain = 1.02, .noise = 0.02, .step = 0.015, .offset = 2, .drift = 0.01},
    {.lag_hz = 100},
    {.gain = 1.02, .lost = 0.3, .lag_hz = 20},
    // Swings of some newtons of a loop for 200 are narrow; their gain is 8 % too small.
    {.hysteresis = 0.15},
    {.late = 3},
};

TEST(DisobeyedLeg, SoundAmplifiersAndReadBacksObey) {
  std::uint64_t seed = 1;
  for (const Way& way : sound) {
    EXPECT_EQ(found_after(way, 100, seed), -1) << seed;
    ++seed;
  }
}

// A quarter of a swing of 1 Hz until the force is large enough to tell.
TEST(DisobeyedLeg, WhatDoesNotIsFoundAndNamed) {
  std::uint64_t seed = 1;
  for (const Way& way : sound) {
    if (way.noise > 0.04 || way.step > 0.05) continue;  // some newtons are little beside that
    const auto found = [&](const std::function<double(double)>& broken) {
      const int after = found_after(way, 5, seed, broken);
      return after >= 0 && after < 500;
    };
    EXPECT_TRUE(found([](double x) { return 1.15 * x; })) << seed;
    EXPECT_TRUE(found([](double x) { return 0.5 * x; })) << seed;
    EXPECT_TRUE(found([](double x) { return -x; })) << seed;
    EXPECT_TRUE(found([](double x) { return x + 3; })) << seed;
    ++seed;
  }
}

// One bad telegram in a row is none, and what acts while commands are not heard is nobody's fault.
TEST(DisobeyedLeg, OneBadReadingIsNoFault) {
  const auto seldom = [n = 0](double x) mutable { return ++n % 3 == 0 ? x : x + 100; };
  EXPECT_EQ(found_after({}, 5, 1, seldom), -1);
}

// A slow amplifier is where nobody has followed it to when measurements come again within a fade.
TEST(DisobeyedLeg, ASlowAmplifierBehindAGapIsNoFault) {
  for (const double lag_hz : {5.0, 20.0, 300.0}) {
    Gains gains = toy::damped_gains();
    gains.instruments.actuator_lag_hz = lag_hz;
    Obedience obedience(gains, Policy{}.disobeyed_part);
    VectorXd acting = VectorXd::Zero(m), before = acting;
    for (int k = 0; k < 500; ++k) obedience.listen(acting);
    obedience.begin();
    const double left = std::exp(-2 * M_PI * lag_hz * gains.sample_time());
    for (int k = 0; k < 3000; ++k) {
      // 10 N, of which 0.1 s of silence take nearly all.
      const bool silent = k >= 1000 && k < 1090;
      const VectorXd force = VectorXd::Constant(m, silent ? 10 - (k - 1000) / 9.0 : 10);
      obedience.command(force);
      acting = left * acting + (1 - left) * before;
      before = force;
      if (silent) continue;
      if (k == 1090) obedience.lose_track();
      obedience.hear(1, acting);
      ASSERT_FALSE(obedience.is_broken()) << lag_hz << " Hz, sample " << k;
    }
    obedience.hear(1, 1.5 * acting);
    obedience.hear(1, 1.5 * acting);
    EXPECT_FALSE(obedience.is_broken());
    obedience.hear(1, 1.5 * acting);
    EXPECT_TRUE(obedience.is_broken()) << lag_hz;
  }
}

/// Legs that fall short of that command as a function of time, at 1 kHz; answers the sample in
/// which one is found, -1: never.
int found_in(double gain, double seconds, const std::function<double(double)>& command) {
  Obedience obedience(toy::damped_gains(), Policy{}.disobeyed_part);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  double acts = 0;
  const auto read = [&] {
    return VectorXd::NullaryExpr(m, [&] { return gain * acts + 2e-3 * normal(random); }).eval();
  };
  for (int k = 0; k < 500; ++k) obedience.listen(read());
  obedience.begin();
  const int n = static_cast<int>(1000 * seconds);
  for (int k = 0; k < n; ++k) {
    obedience.hear(1, read());
    if (obedience.is_broken()) return k;
    acts = command(1e-3 * k);
    obedience.command(VectorXd::Constant(m, acts));
  }
  return -1;
}

/// Comes up within a second, is held, and goes within a second.
double held(double newtons, double seconds, double t) {
  return newtons * smooth_step(std::clamp(std::min(t, seconds + 1 - t), 0.0, 1.0));
}

// By up to a quarter, as docs/safety.md allows: while a force is held that is taken for the zero of
// its read-back within seconds, and is none when it goes.
TEST(DisobeyedLeg, OneThatFallsShortMayHoldAForceAndLetGoOfIt) {
  for (const double gain : {0.98, 0.92, 0.9, 0.85, 0.8, 0.76}) {
    for (const double seconds : {3.0, 10.0, 30.0}) {
      const auto command = [&](double t) { return held(20, seconds, t); };
      EXPECT_EQ(found_in(gain, seconds + 5, command), -1) << gain << " " << seconds;
    }
    for (const double hz : {0.01, 0.02, 0.05, 0.1, 0.5}) {
      const auto command = [&](double t) {
        return 20 * std::min(1.0, t) * std::sin(2 * M_PI * hz * t);
      };
      EXPECT_EQ(found_in(gain, 200, command), -1) << gain << " " << hz << " Hz";
    }
  }
}

// What is learned of such a leg hides nothing of what breaks later, while it holds a force.
TEST(DisobeyedLeg, OneThatFallsShortIsStillFoundByMore) {
  for (const double gain : {1.0, 0.9}) {
    const auto command = [](double t) { return held(20, 30, t) + std::sin(2 * M_PI * t); };
    for (const double later : {1.3, -1.0, 0.5}) {
      Obedience obedience(toy::damped_gains(), Policy{}.disobeyed_part);
      for (int k = 0; k < 500; ++k) obedience.listen(VectorXd::Constant(m, k % 2 * 1e-3));
      obedience.begin();
      int k = 0;
      for (; k < 20'100 && !obedience.is_broken(); ++k) {
        VectorXd says = VectorXd::Constant(m, gain * command(1e-3 * (k - 1)));
        if (k >= 20'000) says(2) *= later;
        obedience.hear(1, says);
        obedience.command(VectorXd::Constant(m, command(1e-3 * k)));
      }
      EXPECT_EQ(obedience.leg(), 2) << gain << " " << later;
      EXPECT_GE(k, 20'000);
    }
  }
}

// By swings, whatever its zero; to a thousandth, which is what 2 mN are of some newtons, and within
// a second of them; never more than all, nor less than three quarters.
TEST(DisobeyedLeg, HowMuchActsIsLearned) {
  for (const double gain : {1.04, 1.0, 0.98, 0.9, 0.76, 0.7}) {
    Obedience obedience(toy::damped_gains(), 1);
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    double before = 0;
    const auto read = [&] {
      return VectorXd::NullaryExpr(m, [&] { return 3 + gain * before + 2e-3 * normal(random); })
          .eval();
    };
    for (int k = 0; k < 500; ++k) obedience.listen(read());
    obedience.begin();
    EXPECT_EQ(obedience.acts(), VectorXd::Ones(m));
    for (int k = 0; k < 5000; ++k) {
      // What was commanded in the sample before acts in this one.
      const double force = 5 + 2 * std::sin(2 * M_PI * 3e-3 * k) + std::sin(2 * M_PI * 9e-3 * k);
      obedience.command(VectorXd::Constant(m, force));
      obedience.hear(1, read());
      before = force;
      if (k < 1000) continue;
      ASSERT_NEAR(obedience.acts()(2), std::clamp(gain, 0.75, 1.0), 1e-3) << gain << " " << k;
    }
  }
}

// One telegram that is wrong while arming hides nothing of what comes later.
TEST(DisobeyedLeg, ABadTelegramWhileArmingHidesNothing) {
  for (const int at : {0, 1, 250, 499}) {
    Obedience obedience(toy::damped_gains(), Policy{}.disobeyed_part);
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    const auto read = [&](double force) {
      return VectorXd::NullaryExpr(m, [&] { return force + 2e-3 * normal(random); }).eval();
    };
    for (int k = 0; k < 500; ++k) {
      VectorXd says = read(0);
      if (k == at) says(1) += 50;
      obedience.listen(says);
    }
    obedience.begin();
    double before = 0;
    int k = 0;
    for (; k < 2000 && !obedience.is_broken(); ++k) {
      VectorXd says = read(before);
      if (k > 1000) says(1) *= 1.5;
      obedience.hear(1, says);
      before = 20 * std::sin(2 * M_PI * 1e-3 * k);
      obedience.command(VectorXd::Constant(m, before));
    }
    EXPECT_EQ(obedience.leg(), 1) << at;
    EXPECT_GT(k, 1000);
    EXPECT_LT(k, 1100);
  }
}

/// Commands are lost for so many samples of a second, and amplifiers hold.
int found_while_held(int lost, double lag_hz, bool one_alone = false) {
  Gains gains = toy::damped_gains();
  gains.instruments.actuator_lag_hz = lag_hz;
  Obedience obedience(gains, Policy{}.disobeyed_part);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const double left = lag_hz > 0 ? std::exp(-2 * M_PI * lag_hz * gains.sample_time()) : 0;
  VectorXd asked = VectorXd::Zero(m), acts = asked;
  const auto read = [&] {
    return VectorXd::NullaryExpr(m, [&](Index i) { return acts(i) + 2e-3 * normal(random); })
        .eval();
  };
  for (int k = 0; k < 500; ++k) obedience.listen(read());
  obedience.begin();
  for (int k = 0; k < 5000; ++k) {
    obedience.hear(1, read());
    if (obedience.is_broken()) return k % 1000;
    acts = left * acts + (1 - left) * asked;
    const double force = 10 * std::min(1.0, 1e-3 * k) * std::sin(2 * M_PI * 3.3e-3 * k);
    obedience.command(VectorXd::Constant(m, force));
    for (Index i = 0; i < m; ++i) {
      const bool hears = k % 1000 >= lost || (one_alone && i != 1);
      if (hears) asked(i) = force;
    }
  }
  return -1;
}

// Longer than this loop would think of: what acts is one of the last commands, and all stand still.
TEST(DisobeyedLeg, AmplifiersThatMissCommandsMayHoldThem) {
  for (const int lost : {10, 20, 40, 80}) {
    for (const double lag_hz : {0.0, 100.0}) {
      EXPECT_EQ(found_while_held(lost, lag_hz), -1) << lost << " " << lag_hz;
    }
  }
  // But not for ever, and not one alone.
  EXPECT_GE(found_while_held(300, 0), 100);
  EXPECT_GE(found_while_held(80, 0, true), 0);
}

// Nothing is compared behind a lag that no sample shows.
TEST(DisobeyedLeg, ALagWithoutEndIsNoNumberBeyondAllNumbers) {
  for (const double lag_hz : {1e-300, 1e-9, 1e300}) {
    Gains gains = toy::damped_gains();
    gains.instruments.actuator_lag_hz = lag_hz;
    Obedience obedience(gains, Policy{}.disobeyed_part);
    for (const double noise : {0.0, 0.01}) obedience.listen(VectorXd::Constant(m, noise));
    obedience.begin();
    obedience.lose_track();
    for (int k = 0; k < 100; ++k) obedience.hear(1, VectorXd::Constant(m, 10));
    EXPECT_EQ(obedience.is_broken(), lag_hz > 1) << lag_hz;
  }
}

// Each of three legs once is no leg three times.
TEST(DisobeyedLeg, ThreeTimesIsOfOneLeg) {
  Obedience obedience(toy::damped_gains(), Policy{}.disobeyed_part);
  const VectorXd force = VectorXd::Constant(m, 10);
  for (int k = 0; k < 500; ++k) obedience.listen(VectorXd::Zero(m));
  obedience.begin();
  for (int k = 0; k < 1000; ++k) {
    obedience.command(force);
    VectorXd applied = force;
    if (k > 100) applied(k % 3) = 20;
    obedience.hear(1, applied);
    ASSERT_FALSE(obedience.is_broken()) << k;
  }
}

TEST(DisobeyedLeg, AnActuatorThatDoesMoreIsNamedWithinSamples) {
  for (const double gain : {1.1, 1.5, 0.0, -1.0}) {
    Rig rig;
    ASSERT_TRUE(rig.reaches(State::active, 3000)) << to_text(rig.fault());
    rig.steps(5000);
    ASSERT_EQ(rig.supervisor().n_faults(), 0) << to_text(rig.fault());
    const std::int64_t since = rig.k();
    rig.actuators = [gain](VectorXd& force) { force(2) *= gain; };
    ASSERT_TRUE(rig.reaches(State::fault, 500)) << gain;
    EXPECT_EQ(rig.fault(), Fault::disobeyed) << gain;
    EXPECT_TRUE(rig.latched());
    EXPECT_EQ(rig.supervisor().first_leg(), 2) << gain;
    RecordProperty("samples", std::to_string(rig.k() - since));
  }
}

// A read-back that shows more than a twentieth is a policy's to allow.
TEST(DisobeyedLeg, AsMuchMoreMayActAsThePolicySays) {
  for (const double part : {0.05, 0.2}) {
    Policy policy;
    policy.disobeyed_part = part;
    Rig rig(policy);
    ASSERT_TRUE(rig.reaches(State::active, 3000)) << to_text(rig.fault());
    rig.steps(5000);
    // The frame feels what was commanded, and one read-back says more.
    rig.steps(2000, [](Measurement& m) {
      m.applied(2) *= 1.1;
      return true;
    });
    EXPECT_EQ(rig.fault() == Fault::disobeyed, part < 0.1) << part << " " << to_text(rig.fault());
  }
}

}  // namespace
}  // namespace stillframe::controller
