#include <gtest/gtest.h>

#include <random>

#include "controller/gains.hpp"
#include "controller/handshake.hpp"
#include "controller/law.hpp"
#include "controller/pace.hpp"
#include "controller/start_check.hpp"
#include "core/errors/input_error.hpp"
#include "tests/controller/rig.hpp"
#include "tests/support/allocation_count.hpp"

// Our own law, written as somebody else's, does in the controller what it did as ours: the same
// forces to rounding, through gaps, arming, ramp, pace and gate.
namespace stillframe::controller {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The toy frame with a feed-forward from its one floor channel.
Gains ours() {
  Gains gains = toy::damped_gains();
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  gains.feed_forward = {{"floor"}, {.memory = 0.98, .n_taps = 4, .weights = MatrixXd(4, 6)}};
  for (double& value : gains.feed_forward.filter.weights.reshaped()) value = 1e-3 * normal(engine);
  return gains;
}

Gains as_brought(Gains gains) {
  const std::vector<std::string> floor = gains.feed_forward.floor;
  gains.law =
      BroughtLaw{.matrices = named(law_from_gains(gains), gains.legs, floor), .floor = floor};
  gains.feed_forward = {};
  gains.lead_samples = gains.leak_hz = 0;
  return gains;
}

TEST(OwnLawRuns, AsOursThroughGaps) {
  const Gains gains = ours();
  Law law(law_from_gains(gains)), own(law_from_gains(as_brought(gains)));
  std::mt19937 engine(2);
  std::normal_distribution<double> normal;
  VectorXd sigma(4), applied(4), w(1), u(4), u_own(4);
  for (int k = 0; k < 400; ++k) {
    for (double& value : sigma) value = normal(engine);
    for (double& value : applied) value = normal(engine);
    w(0) = normal(engine);
    const std::int64_t n = k % 7 == 0 ? 1 + k % 5 : k == 200 ? 150 : 1;
    law.hear_floor(n, w, 0.5);
    own.hear_floor(n, w, 0.5);
    law.step_over(n, sigma, applied, u);
    own.step_over(n, sigma, applied, u_own);
    // Sums in another order.
    ASSERT_LT((u - u_own).norm(), 1e-10 * (1 + u.norm())) << k;
  }
}

/// Our feedback as somebody else's, and our feed-forward beside it.
Gains with_ours_beside(const Gains& gains) {
  Gains deaf = gains;
  deaf.feed_forward = {};
  Gains made = as_brought(deaf);
  made.feed_forward = gains.feed_forward;
  return made;
}

TEST(OwnLawRuns, WithAFeedForwardOfOursBesideIt) {
  const Gains gains = ours();
  const std::string text = to_yaml(with_ours_beside(gains));
  const Gains beside = parse_gains(text, "gains.yaml");
  EXPECT_EQ(to_yaml(beside), text);
  EXPECT_EQ(beside.heard_floor(), std::vector<std::string>{"floor"});
  Law law(law_from_gains(gains)), own(law_from_gains(beside));
  std::mt19937 engine(3);
  std::normal_distribution<double> normal;
  VectorXd sigma(4), applied(4), w(1), u(4), u_own(4);
  for (int k = 0; k < 400; ++k) {
    for (double& value : sigma) value = normal(engine);
    for (double& value : applied) value = normal(engine);
    w(0) = normal(engine);
    law.hear_floor(1, w, 0.5);
    own.hear_floor(1, w, 0.5);
    law.step(sigma, applied, u);
    own.step(sigma, applied, u_own);
    // Sums in another order.
    ASSERT_LT((u - u_own).norm(), 1e-10 * (1 + u.norm())) << k;
  }
  Gains deaf = beside;
  deaf.forget_floor();
  EXPECT_TRUE(deaf.heard_floor().empty());
  EXPECT_EQ(law_from_gains(deaf).feed_forward.D.size(), 0);
}

TEST(OwnLawRuns, HearsTheFloorOnce) {
  Gains twice = as_brought(ours());
  twice.feed_forward = ours().feed_forward;
  try {
    parse_gains(to_yaml(twice), "gains.yaml");
    FAIL() << "two feed-forwards were taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("a law that hears the floor itself"),
              std::string::npos)
        << error.what();
  }
}

TEST(OwnLawRuns, WithoutAllocation) {
  Law own(law_from_gains(as_brought(ours())));
  VectorXd sigma = VectorXd::Ones(4), applied = sigma, w = VectorXd::Ones(1), u(4);
  const auto before = test::allocation_count();
  for (int k = 0; k < 10; ++k) {
    own.hear_floor(1 + k % 3, w);
    own.step_over(1 + k % 3, sigma, applied, u);
  }
  EXPECT_EQ(test::allocation_count(), before);
}

TEST(OwnLawRuns, ComesBackFromItsGainsFileToTheBit) {
  Gains none = as_brought(ours());
  none.law->matrices.A.resize(0, 0);
  none.law->matrices.B.resize(0, none.law->matrices.D.cols());
  none.law->matrices.C.resize(4, 0);
  for (const Gains& gains : {as_brought(ours()), none}) {
    const std::string text = to_yaml(gains);
    const Gains back = parse_gains(text, "gains.yaml");
    ASSERT_TRUE(back.law);
    EXPECT_EQ(back.law->floor, gains.law->floor);
    EXPECT_EQ(back.law->matrices.inputs, gains.law->matrices.inputs);
    EXPECT_EQ(back.law->matrices.outputs, gains.law->matrices.outputs);
    EXPECT_EQ(back.law->matrices.A, gains.law->matrices.A);
    EXPECT_EQ(back.law->matrices.B, gains.law->matrices.B);
    EXPECT_EQ(back.law->matrices.C, gains.law->matrices.C);
    EXPECT_EQ(back.law->matrices.D, gains.law->matrices.D);
    EXPECT_EQ(to_yaml(back), text);
  }
}

TEST(OwnLawRuns, IsLookedAtWhenItsGainsFileIsRead) {
  const auto refused = [](const std::string& from, const std::string& to) -> std::string {
    std::string text = to_yaml(as_brought(ours()));
    const auto at = text.find(from, text.find("\nlaw:"));
    EXPECT_NE(at, std::string::npos);
    text.replace(at, from.size(), to);
    try {
      parse_gains(text, "gains.yaml");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const auto says = [](const std::string& said, const char* what) {
    EXPECT_NE(said.find(what), std::string::npos) << said;
  };
  says(refused("sigma:leg_1", "sigma:leg_7"), "law: inputs: found \"sigma:leg_7\"");
  says(refused("\"floor\"", "\"floor\", \"b\""), "law.floor: found 2 names");
  says(refused("force:leg_1", "force:leg_2"), "twice");
  says(refused("inputs:", "input:"), "input");
}

TEST(OwnLawRuns, HearsTheFloorThatItsPlantMeasures) {
  const Gains gains = as_brought(ours());
  EXPECT_EQ(gains.heard_floor(), std::vector<std::string>{"floor"});
  Gains deaf = gains;
  deaf.forget_floor();
  EXPECT_TRUE(deaf.heard_floor().empty());
  EXPECT_EQ(law_from_gains(deaf).feed_forward.D.size(), 0);
  stillframe_msgs::run_info_t info{};
  info.format_version = 1;
  info.scene_hash = gains.scene_hash;
  info.leg_names = gains.legs;
  info.n_legs = 4;
  info.n_floor = 1;
  info.n_samples = 1;
  info.sample_rate_hz = gains.sample_rate_hz;
  info.delay_samples = gains.delay_samples;
  info.mode = "lock_step";
  info.loop = "active";
  info.floor_names = {"floor"};
  EXPECT_EQ(disagreement(gains, info), "");
  info.floor_names = {"other"};
  EXPECT_NE(disagreement(gains, info).find("law: floor: the gains file says [floor]"),
            std::string::npos);
  EXPECT_EQ(disagreement(deaf, info), "");
}

TEST(OwnLawRuns, HasThePaceOfOurs) {
  const Gains gains = ours();
  const Pace pace(gains, {}), own(as_brought(gains), {});
  // Responses of some thousand samples, which rounding is the only difference of.
  EXPECT_LT((own.per_floor() - pace.per_floor()).norm(), 1e-9 * pace.per_floor().norm());
  EXPECT_LT((own.per_noise() - pace.per_noise()).norm(), 1e-9 * pace.per_noise().norm());
  EXPECT_NEAR(ramp_radius(as_brought(gains)), ramp_radius(gains), 1e-6);
  EXPECT_NEAR(require_stable(as_brought(gains)), require_stable(gains), 1e-6);
}

TEST(OwnLawRuns, ArmsRampsAndActsAsOurs) {
  const Gains gains = ours();
  Rig rig({}, true, gains), own({}, true, as_brought(gains), gains);
  const auto lossy = [](Measurement& measurement) { return measurement.seq % 13 != 5; };
  double largest = 0;
  State before = State::idle;
  for (int k = 0; k < 6000; ++k) {
    const Rig::Wire wire = k > 4000 ? Rig::Wire(lossy) : Rig::Wire();
    rig.step(wire);
    own.step(wire);
    ASSERT_EQ(own.state(), rig.state()) << k;
    largest = std::max(largest, rig.force().norm());
    // Rounding, through a loop that forgets within a second.
    ASSERT_LT((own.force() - rig.force()).norm(), 1e-8 * (1 + largest)) << k;
    before = rig.state();
  }
  EXPECT_EQ(before, State::active);
  EXPECT_GT(largest, 1);
}

TEST(OwnLawRuns, IsRefusedWhereItsLoopIsUnstable) {
  Gains gains = as_brought(ours());
  gains.law->matrices.D *= -3;
  gains.law->matrices.C *= -3;
  try {
    require_stable(gains);
    FAIL();
  } catch (const Refusal& refusal) {
    const std::string said = refusal.what();
    EXPECT_NE(said.find("the law that was brought"), std::string::npos) << said;
    EXPECT_EQ(said.find("leak_hz"), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace stillframe::controller
