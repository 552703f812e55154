#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "controller/answer.hpp"
#include "controller/designed_loop.hpp"
#include "controller/floor_filter.hpp"
#include "controller/floor_watch.hpp"
#include "controller/handshake.hpp"
#include "core/control/feed_forward_design.hpp"
#include "core/errors/input_error.hpp"
#include "tests/controller/rig.hpp"
#include "tests/support/allocation_count.hpp"

// The feed-forward as the controller runs it: the same system as the analysis has, through gaps and
// from its gains file, and faded out where a sensor of the floor is not to be believed.
namespace stillframe::controller {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(Index rows, Index cols, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  MatrixXd out(rows, cols);
  for (double& value : out.reshaped()) value = normal(engine);
  return out;
}

FeedForward filter_of(Index m, Index p) {
  return {.memory = 0.98, .n_taps = 4, .weights = random_matrix(m, 6 * p, 1)};
}

/// The toy frame with feed-forward from its one floor channel.
Gains gains_with_floor() {
  Gains gains = toy::damped_gains();
  gains.feed_forward = {{"floor"}, filter_of(gains.n_legs(), 1)};
  return gains;
}

TEST(FloorFilter, IsTheSystemOfTheAnalysis) {
  const LinearSystem system = feed_forward_system(filter_of(3, 2));
  FloorFilter filter(system, 3);
  filter.rest();
  const MatrixXd w = random_matrix(2, 400, 2);
  VectorXd x = VectorXd::Zero(system.A.rows());
  for (Index k = 0; k < w.cols(); ++k) {
    filter.hear(1, w.col(k));
    const VectorXd should = system.C * x + system.D * w.col(k);
    x = (system.A * x + system.B * w.col(k)).eval();
    // Sums in another order.
    ASSERT_LT((filter.force() - should).norm(), 1e-12 * (1 + should.norm())) << k;
  }
}

TEST(FloorFilter, TakesLostSamplesToLieOnALine) {
  const LinearSystem system = feed_forward_system(filter_of(3, 2));
  FloorFilter all(system, 3), some(system, 3);
  const MatrixXd w = random_matrix(2, 40, 3);
  for (Index k = 0; k < w.cols(); ++k) {
    const std::int64_t n = 1 + k % 5;
    const VectorXd before = w.col(std::max<Index>(0, k - 1)), now = w.col(k);
    for (std::int64_t j = 1; j <= n; ++j) {
      const double part = static_cast<double>(j) / static_cast<double>(n);
      all.hear(1, before + part * (now - before));
    }
    some.hear(n, now);
    ASSERT_LT((all.force() - some.force()).norm(), 1e-12 * (1 + all.force().norm())) << k;
  }
}

TEST(FloorFilter, TakesItsFirstReadingAndThatAfterALongGapForRest) {
  FloorFilter filter(feed_forward_system(filter_of(3, 2)), 3);
  const VectorXd offset = VectorXd::Constant(2, 5.0);
  for (const std::int64_t n : {std::int64_t{1}, FloorFilter::longest_gap + 1}) {
    for (int k = 0; k < 50; ++k) {
      filter.hear(k == 0 ? n : 1, offset);
      // Of 5 m/s^2, weights of some N per m/s^2, what is rounded.
      ASSERT_LT(filter.force().norm(), 1e-12) << k;
    }
    filter.hear(1, 2 * offset);
    EXPECT_GT(filter.force().norm(), 1);
  }
}

TEST(FloorFilter, LetsGoOfItsForceWhileItIsNotBelievedAndBeginsWithTheMean) {
  FloorFilter filter(feed_forward_system(filter_of(3, 2)), 3);
  const MatrixXd w = random_matrix(2, 50, 3);
  filter.rest();
  for (Index k = 0; k < w.cols(); ++k) filter.hear(1, w.col(k));
  const double before = filter.force().norm();
  // To a third within ten samples, whatever is read.
  for (Index k = 0; k < 10; ++k) filter.hear(1, 1e3 * w.col(k), false);
  EXPECT_NEAR(filter.force().norm(), std::pow(0.9, 10) * before, 1e-9 * before);
  // A hum about five: what stands for ever is five.
  for (int k = 0; k < 5000; ++k)
    filter.hear(1, VectorXd::Constant(2, k % 2 == 0 ? 4.0 : 6.0), false);
  filter.hear(1, VectorXd::Constant(2, 5.0));
  // A reading that is off by 1 m/s^2 leaves 850 N, the mean of a thousand half a thousandth of it.
  EXPECT_LT(filter.force().norm(), 1);
}

TEST(FloorFilter, DoesNotAllocate) {
  FloorFilter filter(feed_forward_system(filter_of(6, 6)), 6);
  const MatrixXd w = random_matrix(6, 10, 4);
  const VectorXd one = w.col(0);
  const auto before = test::allocation_count();
  for (int k = 0; k < 10; ++k) filter.hear(1 + k % 3, one);
  filter.hear(1000, one);
  EXPECT_EQ(test::allocation_count(), before);
}

TEST(LawWithFeedForward, AddsItsForceToThatOfTheFeedback) {
  const Gains gains = gains_with_floor();
  Gains without = gains;
  without.feed_forward = {};
  Law law(law_from_gains(gains)), feedback(law_from_gains(without));
  FloorFilter filter(feed_forward_system(gains.feed_forward.filter), gains.n_legs());
  const MatrixXd sigma = random_matrix(4, 30, 5), w = random_matrix(1, 30, 6);
  VectorXd force = VectorXd::Zero(4), alone = force;
  const VectorXd applied = force;
  for (Index k = 0; k < 30; ++k) {
    const double share = k < 20 ? 1 : 0.25;
    law.hear_floor(1, w.col(k), share);
    filter.hear(1, w.col(k));
    law.step(sigma.col(k), applied, force);
    feedback.step(sigma.col(k), applied, alone);
    ASSERT_EQ(force, alone + share * filter.force()) << k;
  }
  law.hear_floor(1, w.col(0), 0);
  law.step(sigma.col(0), applied, force);
  feedback.step(sigma.col(0), applied, alone);
  EXPECT_EQ(force, alone);
}

TEST(LawWithFeedForward, WithoutOneIsTheLawThatItWas) {
  Law law(law_from_gains(toy::damped_gains())), other(law_from_gains(toy::damped_gains()));
  const MatrixXd sigma = random_matrix(4, 30, 7);
  VectorXd a = VectorXd::Zero(4), b = a;
  const VectorXd applied = a;
  for (Index k = 0; k < 30; ++k) {
    law.hear_floor(1, sigma.col(k).head(1));
    law.step(sigma.col(k), applied, a);
    other.step(sigma.col(k), applied, b);
    ASSERT_EQ(a, b);
  }
}

TEST(GainsWithFeedForward, ComeBackToTheBit) {
  const Gains gains = gains_with_floor();
  const Gains read = parse_gains(to_yaml(gains), "gains.yaml");
  EXPECT_EQ(read.feed_forward.floor, gains.feed_forward.floor);
  EXPECT_EQ(read.feed_forward.filter.memory, gains.feed_forward.filter.memory);
  EXPECT_EQ(read.feed_forward.filter.n_taps, gains.feed_forward.filter.n_taps);
  EXPECT_EQ(read.feed_forward.filter.weights, gains.feed_forward.filter.weights);
  EXPECT_TRUE(parse_gains(to_yaml(toy::damped_gains()), "").feed_forward.filter.empty());
}

std::string error_with(const std::string& from, const std::string& to) {
  std::string text = to_yaml(gains_with_floor());
  const auto at = text.find(from, text.find("feed_forward:"));
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  try {
    parse_gains(text, "gains.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(GainsWithFeedForward, AreRefusedWithFileLineKeyAndWhatIsAllowed) {
  const struct {
    std::string from, to, message;
  } cases[] = {
      {"floor: [\"floor\"]", "floor: [\"a\", \"b\"]",
       "found 2 names, allowed is one for each acceleration of the floor that plant: B_w has, 1"},
      {"floor: [\"floor\"]", "floor: [\"a\", \"a\"]", "found \"a\" twice"},
      {"floor: [\"floor\"]", "floors: [\"floor\"]", "floors: unknown key"},
      {"memory: 0.97", "memory: 1.97", "found '1.97"},
      {"taps: 4", "taps: 5", "weights"},
      {"taps: 4", "taps: 1", "taps"},
      {"taps: 4", "taps: 4000", "allowed are 2 to 64"},
  };
  for (const auto& [from, to, message] : cases) {
    const std::string error = error_with(from, to);
    EXPECT_NE(error.find(message), std::string::npos) << to << ": " << error;
    EXPECT_EQ(error.find("gains.yaml:"), 0U) << error;
    EXPECT_NE(error.find("feed_forward"), std::string::npos) << error;
  }
}

TEST(GainsWithFeedForward, AreForAPlantThatMeasuresWhatTheyHear) {
  const Gains gains = gains_with_floor();
  stillframe_msgs::run_info_t info{};
  info.format_version = 1;
  info.scene_hash = gains.scene_hash;
  info.leg_names = gains.legs;
  info.n_legs = static_cast<std::int32_t>(gains.n_legs());
  info.n_samples = 10;
  info.sample_rate_hz = gains.sample_rate_hz;
  info.delay_samples = gains.delay_samples;
  info.mode = "lock_step";
  info.loop = "active";
  info.floor_names = {"floor"};
  info.n_floor = 1;
  EXPECT_EQ(disagreement(gains, info), "");
  info.floor_names = {"another"};
  EXPECT_NE(disagreement(gains, info)
                .find("feed_forward: floor: the gains file says [floor], the "
                      "plant says [another]"),
            std::string::npos);
  info.floor_names = {};
  EXPECT_NE(disagreement(gains, info), "");
}

/// A watch of two sensors that read noise.
class Watched : public testing::Test {
 protected:
  static constexpr double rate = 1000;

  void hear(int n, bool first_moves, bool second_moves) {
    for (int k = 0; k < n; ++k) {
      const VectorXd next = random_matrix(2, 1, ++seed_);
      if (first_moves) w_(0) = next(0);
      if (second_moves) w_(1) = next(1);
      const double before = watch_.share();
      watch_.hear(1, w_);
      // No faster than the fade: 15/8 of the mean slope.
      steepest_ = std::max(steepest_, std::abs(watch_.share() - before) * rate);
    }
  }

  Policy policy_{.ramp_in_s = 0.5, .fade_s = 0.25};
  FloorWatch watch_{2, policy_, 1 / rate};
  VectorXd w_ = VectorXd::Zero(2);
  double steepest_ = 0;
  unsigned seed_ = 0;
  int k_ = 0;
};

TEST_F(Watched, FadesTheFeedForwardOutWhileASensorRepeatsItself) {
  hear(500, true, true);
  EXPECT_EQ(watch_.share(), 1);
  EXPECT_EQ(watch_.broken(), -1);
  hear(99, true, false);
  EXPECT_EQ(watch_.broken(), -1);
  hear(260, true, false);
  EXPECT_EQ(watch_.broken(), 1);
  EXPECT_EQ(watch_.share(), 0);
  EXPECT_LT(steepest_, 1.9 / policy_.fade_s);
  EXPECT_FALSE(watch_.believed());
  hear(1490, true, true);
  EXPECT_EQ(watch_.share(), 0);
  EXPECT_TRUE(watch_.believed());
  hear(600, true, true);
  EXPECT_EQ(watch_.share(), 1);
  EXPECT_EQ(watch_.broken(), -1);
}

TEST_F(Watched, TakesAFloorAtRestForWhatItIs) {
  hear(500, false, false);
  hear(500, true, true);
  hear(2000, false, false);
  hear(10, true, true);
  EXPECT_EQ(watch_.share(), 1);
}

TEST_F(Watched, DoesNotAskForASensorThatNeverMoved) {
  hear(2000, true, false);
  EXPECT_EQ(watch_.share(), 1);
}

TEST_F(Watched, FadesTheFeedForwardOutWhileASensorReadsNoise) {
  // Motion of 1 mm/s^2 at 7 and 11 Hz with a hundredth of noise, and more noise on the second from
  // so many samples on.
  const auto hear_motion = [&](int n, double noise) {
    for (int k = 0; k < n; ++k, ++k_) {
      const VectorXd white = random_matrix(2, 1, ++seed_);
      const double t = k_ / rate;
      w_(0) = 1e-3 * std::sin(two_pi * 7 * t) + 1e-5 * white(0);
      w_(1) = 1e-3 * std::sin(two_pi * 11 * t) + noise * white(1);
      const double before = watch_.share();
      watch_.hear(1, w_);
      steepest_ = std::max(steepest_, std::abs(watch_.share() - before) * rate);
    }
  };
  hear_motion(2000, 1e-5);
  // Noise of a tenth of the motion is ten times that of the other: it does no harm yet.
  hear_motion(2000, 1.1e-4);
  EXPECT_EQ(watch_.broken(), -1);
  hear_motion(100, 1e-2);
  EXPECT_EQ(watch_.broken(), 1);
  hear_motion(400, 1e-2);
  EXPECT_EQ(watch_.share(), 0);
  EXPECT_LT(steepest_, 1.9 / policy_.fade_s);
  // What is remembered of the noise goes down by 1e6 in three seconds.
  hear_motion(5000, 1e-5);
  EXPECT_EQ(watch_.share(), 1);
  EXPECT_EQ(watch_.broken(), -1);
}

TEST_F(Watched, DoesNotBelieveASensorFromTheSampleOnInWhichItLeaps) {
  const auto hear_motion = [&](int n) {
    for (int k = 0; k < n; ++k, ++k_) {
      w_(0) = 1e-3 * std::sin(two_pi * 7 * k_ / rate);
      w_(1) = 1e-3 * std::sin(two_pi * 11 * k_ / rate);
      watch_.hear(1, w_);
    }
  };
  hear_motion(2000);
  EXPECT_TRUE(watch_.believed());
  // Twice the motion is none.
  w_(1) += 2e-3;
  watch_.hear(1, w_);
  EXPECT_TRUE(watch_.believed());
  hear_motion(10);
  w_(1) += 1;
  watch_.hear(1, w_);
  EXPECT_FALSE(watch_.believed());
  EXPECT_EQ(watch_.broken(), 1);
}

TEST_F(Watched, TakesAToneNearHalfTheRateOnOneSensorForMotion) {
  for (int k = 0; k < 2000; ++k) {
    const VectorXd white = random_matrix(2, 1, ++seed_);
    w_(0) = 1e-5 * white(0);
    w_(1) = 1e-2 * std::sin(two_pi * 0.45 * k) + 1e-5 * white(1);
    watch_.hear(1, w_);
  }
  EXPECT_EQ(watch_.share(), 1);
}

/// The toy frame on two floors, one below the two soft legs, one below the two stiff ones, with the
/// feed-forward that is designed for it. Its masses are accelerated by what the sensors read.
Gains designed_gains(bool with_feed_forward = true) {
  Gains gains = toy::damped_gains();
  gains.lead_samples = 0.3;
  gains.force_limit_n = 2000;  // such a floor moves by millimetres, and legs of 95 kN/m hold still
  const Index n = gains.plant.A.rows(), m = gains.n_legs();
  gains.plant.B_w = MatrixXd::Zero(n, 2);
  gains.plant.B_w.block(m, 0, 2, 1).setConstant(-1);
  gains.plant.B_w.block(m + 2, 1, 2, 1).setConstant(-1);
  if (!with_feed_forward) return gains;
  const LoopSettings loop{.plant = gains.loop_plant(),
                          .feedback = gains.feedback(),
                          .law = gains.law_sampling(),
                          .sampling = gains.sampling()};
  const auto goal = [](double omega) {
    const std::complex<double> s(0, omega), omega_d = two_pi * 5;
    const auto T = omega_d * omega_d / (s * s + 1.4 * omega_d * s + omega_d * omega_d);
    Eigen::MatrixXcd all = Eigen::MatrixXcd::Zero(4, 2);
    all.block(0, 0, 2, 1).setConstant(-T);
    all.block(2, 1, 2, 1).setConstant(-T);
    return all;
  };
  gains.feed_forward = {{"soft", "stiff"},
                        design_feed_forward(loop, goal, {.to_hz = 50, .corner_hz = 0.5})};
  return gains;
}

/// The largest root mean square of the acceleration of a mass, the means over the samples, in a run
/// that is active. At the samples there is the ripple of held forces in it.
struct Trial {
  explicit Trial(const Gains& gains, bool active = true) : rig({}, active, gains) {
    if (active) EXPECT_TRUE(rig.reaches(State::active, 2500));
  }
  double rms(int n, const Rig::Wire& wire = {}) {
    VectorXd sum = VectorXd::Zero(4);
    for (int k = 0; k < n; ++k) {
      rig.step(wire);
      sum += rig.y.cwiseAbs2();
    }
    return std::sqrt(sum.maxCoeff() / n);
  }
  Rig rig;
};

constexpr int twenty_seconds = 20'000;

TEST(SupervisorWithFeedForward, IsolatesMoreAndTakesItsOwnCommandsForSound) {
  Trial with(designed_gains()), without(designed_gains(false));
  // A lead of 0.3 for the margin leaves half of what a floor of 10 Hz does at 49 Hz; the
  // feed-forward takes nine tenths of that away, and follows below its target.
  EXPECT_LT(with.rms(twenty_seconds), 0.7 * without.rms(twenty_seconds));
  EXPECT_EQ(with.rig.state(), State::active);
  EXPECT_EQ(with.rig.fault(), Fault::none);
  EXPECT_EQ(with.rig.supervisor().broken_floor(), -1);
}

TEST(SupervisorWithFeedForward, GoesOnByFeedbackAloneWhereASensorDies) {
  Trial run(designed_gains()), alone(designed_gains(false)), passive(designed_gains(false), false);
  double frozen = 0;
  run.rms(2000);
  run.rig.step([&](Measurement& m) {
    frozen = m.floor(1);
    return true;
  });
  const auto dead = [&](Measurement& m) {
    m.floor(1) = frozen;
    return true;
  };
  run.rig.largest_jump = alone.rig.largest_jump = 0;
  run.rms(2000, dead);
  alone.rms(4000);
  EXPECT_EQ(run.rig.supervisor().broken_floor(), 1);
  // No step in the force that is not one of the loop's own.
  EXPECT_LT(run.rig.largest_jump, 3 * alone.rig.largest_jump);
  const double left = run.rms(twenty_seconds, dead);
  EXPECT_NEAR(left, alone.rms(twenty_seconds), 0.2 * left);
  EXPECT_LT(left, passive.rms(twenty_seconds));
  EXPECT_EQ(run.rig.state(), State::active);
  run.rms(3000);
  EXPECT_EQ(run.rig.supervisor().broken_floor(), -1);
  EXPECT_EQ(run.rig.fault(), Fault::none);
}

TEST(SupervisorWithFeedForward, IsNoWorseThanPassiveWithASensorThatBecomesNoisy) {
  // The floor of the bench has some 0.1 m/s^2 of rms; noise of ten times that.
  Trial run(designed_gains()), passive(designed_gains(false), false);
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  double largest = 0;
  const auto noisy = [&](Measurement& m) {
    largest = std::max(largest, std::abs(m.floor(1)));
    m.floor(1) += normal(random);
    return true;
  };
  run.rms(2000);
  run.rig.peak = run.rig.peak_y = 0;
  passive.rms(2000);
  passive.rig.peak = passive.rig.peak_y = 0;
  run.rms(2000, noisy);
  EXPECT_EQ(run.rig.supervisor().broken_floor(), 1);
  run.rms(twenty_seconds - 2000, noisy);
  passive.rms(twenty_seconds);
  EXPECT_LT(largest, 1);
  EXPECT_LT(run.rig.peak_y, passive.rig.peak_y);
  EXPECT_EQ(run.rig.state(), State::active);
}

TEST(SupervisorWithFeedForward, IsNoWorseThanPassiveWithSensorsSwapped) {
  Trial run(designed_gains()), passive(designed_gains(false), false);
  const auto swapped = [](Measurement& m) {
    std::swap(m.floor(0), m.floor(1));
    return true;
  };
  passive.rms(2000);
  EXPECT_LT(run.rms(twenty_seconds, swapped), passive.rms(twenty_seconds));
}

TEST(SupervisorWithFeedForward, DoesNotAllocate) {
  Supervisor supervisor(designed_gains(), {}, true);
  Measurement measurement = measurement_of(4, 2);
  Command command = command_of(4);
  const MatrixXd values = 1e-3 * random_matrix(6, 4000, 9);
  const auto before = test::allocation_count();
  for (Index k = 0; k < values.cols(); ++k) {
    measurement.seq = k;
    measurement.time_ns = k * 1'000'000;
    measurement.sigma = values.col(k).head(4);
    // Alive, broken, and well again.
    measurement.floor(0) = values(4, k);
    if (k < 2500 || k > 2700) measurement.floor(1) = values(5, k);
    supervisor.step({.measurement = &measurement, .defect = Defect::none}, command);
    measurement.applied = command.force;
  }
  EXPECT_EQ(test::allocation_count(), before);
  EXPECT_EQ(supervisor.state(), State::active);
}

TEST(SupervisorWithFeedForward, HasTheSameMemoryAfterARestore) {
  const Gains gains = designed_gains();
  Supervisor one(gains, {}, true), other(gains, {}, true);
  Measurement measurement = measurement_of(4, 2);
  Command a = command_of(4), b = command_of(4);
  const MatrixXd values = random_matrix(6, 3000, 8);
  for (Index k = 0; k < values.cols(); ++k) {
    measurement.seq = k;
    measurement.time_ns = k * 1'000'000;
    measurement.sigma = 1e-3 * values.col(k).head(4);
    measurement.floor(0) = 1e-3 * values(4, k);
    // So that the restore is in the middle of a fade.
    if (k < 1000 || k > 1500) measurement.floor(1) = 1e-3 * values(5, k);
    if (k == 1234) {
      EXPECT_EQ(one.broken_floor(), 1);
      std::vector<double> memory(one.memory_size());
      one.save(memory);
      other.restore(memory);
    }
    const Event event{.measurement = &measurement, .defect = Defect::none};
    one.step(event, a);
    if (k < 1234) continue;
    other.step(event, b);
    ASSERT_EQ(a.force, b.force) << k;
    measurement.applied = a.force;
  }
}

}  // namespace
}  // namespace stillframe::controller
