#include <gtest/gtest.h>

#include "controller/designed_loop.hpp"
#include "controller/pace_scale.hpp"

// The bound of pace_scale.hpp term by term, on a loop whose numbers are powers of two and small
// integers, so that it is met to the last bit.
namespace stillframe::controller {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Two legs, two sensors and one channel of the floor, a = 1/2, after a sample of the
///   floor   z = (4, 2) and (0, 8): L = (6, 8), D = (8, 16), halved by every sample
///   sensors z = (3, 4) of leg 0 and (1, 0) of leg 1: N2 = diag(25, 1)
///   offsets z = (1, -1.5) and (2, 1): B = diag(1.5, 2);   free / (1 - a) = (1, 0.5)
class PaceScaleOfTwoLegs : public testing::Test {
 protected:
  PaceScaleOfTwoLegs() {
    scale_.learn(MatrixXd{{4, 0}, {0, 8}}, 0);
    scale_.learn(MatrixXd{{3, 2.5}, {0, 0}}, 1);
    scale_.learn(MatrixXd{{0, 0}, {1, -0.5}}, 2);
    scale_.learn_offset(MatrixXd{{1, -2}, {0, 0}}, 0);
    scale_.learn_offset(MatrixXd{{0, 0}, {2, 0}}, 1);
    scale_.allow(VectorXd{{0.5, 0.25}});
    begin();
  }
  /// With nothing but what is always allowed beside.
  void begin() { scale_.begin(VectorXd::Zero(2), VectorXd::Zero(2)); }
  void expect(std::int64_t n, double one, double other) {
    scale_.expect(n, VectorXd{{one, other}});
  }
  /// The bound without what is always allowed.
  double most(Eigen::Index leg, double floor, double n = 1) const {
    const VectorXd largest{{floor}};
    return scale_.most(leg, &largest, n) - n * free_(leg);
  }
  double most_on_any_floor(Eigen::Index leg, double n = 1) const {
    return scale_.most(leg, nullptr, n) - n * free_(leg);
  }

  PaceScale scale_{2, 1, 0.5};
  const VectorXd free_{{1, 0.5}};
};

TEST_F(PaceScaleOfTwoLegs, NoiseAndOffsetsCountWithEverySample) {
  scale_.begin(VectorXd{{2, 1}}, VectorXd{{4, 9}});
  // Nine standard deviations: 9 (25 4)^1/2 + 1.5 2, and 9 (1 9)^1/2 + 2 1.
  for (const double n : {1.0, 3.0}) {
    EXPECT_DOUBLE_EQ(most(0, 100, n), n * 93);
    EXPECT_DOUBLE_EQ(most(1, 100, n), n * 29);
    EXPECT_DOUBLE_EQ(most_on_any_floor(0, n), n * 93);
  }
  scale_.forget(0.5, 1, false, true);
  EXPECT_DOUBLE_EQ(most(0, 100), 91.5);  // of the offset half
}

// z = (1, -1.5) of leg 0 that held 2 N, the second for when half is left of it: R = max(1, 3) / 2.
TEST_F(PaceScaleOfTwoLegs, AForceThatIsLetGoOfCountsUntilItIsForgotten) {
  scale_.learn_letting_go(MatrixXd{{1, -2}, {0, 0}}, 0, -2, 0.5);
  begin();
  scale_.let_go(VectorXd{{-4, 100}});
  scale_.let_go(VectorXd{{1, 0}});  // no more than what is there already
  EXPECT_DOUBLE_EQ(most(0, 0), 6);
  EXPECT_DOUBLE_EQ(most(1, 0), 0);
  EXPECT_DOUBLE_EQ(most_on_any_floor(0, 3), 18);
  scale_.forget(0.5, 1, false, true);
  EXPECT_DOUBLE_EQ(most(0, 0), 3);
  begin();
  EXPECT_DOUBLE_EQ(most(0, 0), 0);
}

TEST_F(PaceScaleOfTwoLegs, TheSwingWhileArmingCountsTwiceAndWithoutAFloorFourTimes) {
  const auto listen = [&] {
    scale_.restart();
    scale_.listen(VectorXd{{99, 99}}, true);  // no change, as none came before
    scale_.listen(VectorXd{{-8, 2}}, false);
    scale_.listen(VectorXd{{0, -4}}, false);  // z = -4 and -3
    begin();
  };
  listen();
  for (const double n : {1.0, 3.0}) {
    EXPECT_DOUBLE_EQ(most(0, 100, n), n * 16);
    EXPECT_DOUBLE_EQ(most(1, 100, n), n * 6);
    EXPECT_DOUBLE_EQ(most_on_any_floor(0, n), n * 32);
    EXPECT_DOUBLE_EQ(most_on_any_floor(1, n), n * 12);
  }
  // Without a floor nothing tells that the frame has come to rest; with the whole gain the loop
  // forgets it by itself, 2^-3 in three samples.
  scale_.forget(0.75, 3, true, false);
  EXPECT_DOUBLE_EQ(most(0, 100), 16);
  scale_.forget(0.75, 3, false, true);
  EXPECT_DOUBLE_EQ(most(0, 100), 12);
  scale_.forget(0.75, 3, true, true);
  EXPECT_DOUBLE_EQ(most(0, 100), 1.5);
}

TEST_F(PaceScaleOfTwoLegs, DiffersFromTheDesignedLoopByAQuarterOfTheFloorOrTwiceItsOwn) {
  expect(1, 10, -6);
  // L W / 4 = 1.5 and 2, of each sample; 2 C = 20 and 12.
  EXPECT_DOUBLE_EQ(most(0, 1), 10 + 1.5);
  EXPECT_DOUBLE_EQ(most(1, 1), 6 + 2);
  EXPECT_DOUBLE_EQ(most(0, 1, 3), 10 + 3 * 1.5);
  EXPECT_DOUBLE_EQ(most(0, 100), 10 + 20);
  EXPECT_DOUBLE_EQ(most(1, 100), 6 + 12);
  EXPECT_DOUBLE_EQ(most(0, 100, 3), 10 + 3 * 20);
  expect(2, 0, 0);  // c = 10 / 4
  EXPECT_DOUBLE_EQ(most(0, 100), 2.5 + 20);
  scale_.forget(0.5, 1, false, true);  // C = 5
  EXPECT_DOUBLE_EQ(most(0, 100), 2.5 + 10);
}

TEST_F(PaceScaleOfTwoLegs, AFloorThatWasNotBelievedIsForgottenAsTheLoopForgetsIt) {
  scale_.doubt_floor(VectorXd{{1}});
  EXPECT_DOUBLE_EQ(most(0, 100), 8);
  EXPECT_DOUBLE_EQ(most(1, 100), 16);
  EXPECT_DOUBLE_EQ(most(0, 100, 3), 24);
  expect(1, 0, 0);
  EXPECT_DOUBLE_EQ(most(0, 100), 4);
  scale_.doubt_floor(VectorXd{{1}});  // beside what is left of the last
  EXPECT_DOUBLE_EQ(most(0, 100), 12);
  expect(2, 0, 0);
  EXPECT_DOUBLE_EQ(most(0, 100), 3);
  begin();
  EXPECT_DOUBLE_EQ(most(0, 100), 0);
}

TEST_F(PaceScaleOfTwoLegs, OffTheDesignedLoopNoMoreThanTheFloorCanAskFor) {
  scale_.lose_track(VectorXd{{1000}});
  EXPECT_DOUBLE_EQ(most(0, 10), 60);
  EXPECT_DOUBLE_EQ(most(1, 10), 80);
  EXPECT_DOUBLE_EQ(most(0, 10, 3), 180);
  // Where the designed loop does more than that, as much as it and a quarter of the floor.
  expect(1, 1000, 0);
  EXPECT_DOUBLE_EQ(most(0, 10), 1015);
  EXPECT_DOUBLE_EQ(most(0, 10, 3), 1045);
}

// After more lost samples than the designed loop follows it may have done at once what the loop
// itself does a sample later.
TEST_F(PaceScaleOfTwoLegs, WhatCatchesUpAfterLossesIsAllowedForAsLongAsItIsRemembered) {
  constexpr std::int64_t followed = DesignedLoop::longest_step;
  const auto lost = [&](std::int64_t n) {
    begin();
    expect(n, 1000, -200);
    expect(1, -500, 100);  // c = 0; of G half is left
    scale_.lose_track(VectorXd{{1000}});
  };
  lost(followed + 1);
  EXPECT_DOUBLE_EQ(most(0, 10), 60 + 500);
  EXPECT_DOUBLE_EQ(most(1, 10), 80 + 100);
  // Once, however many samples' changes are made now.
  EXPECT_DOUBLE_EQ(most(0, 10, 3), 3 * 60 + 500);
  expect(1, 0, 0);
  EXPECT_DOUBLE_EQ(most(0, 10), 60 + 250);
  expect(8, 0, 0);
  scale_.lose_track(VectorXd{{1000}});
  EXPECT_DOUBLE_EQ(most(0, 10), 60 + 250.0 / 256);
  lost(followed + 1);
  begin();
  scale_.lose_track(VectorXd{{1000}});
  EXPECT_DOUBLE_EQ(most(0, 10), 60);
  lost(followed);
  EXPECT_DOUBLE_EQ(most(0, 10), 60);
}

TEST_F(PaceScaleOfTwoLegs, WhatIsCommandedIsSetAgainstTheBound) {
  expect(1, 10, -6);
  scale_.command(1, VectorXd{{8, 1}});
  scale_.command(2, VectorXd{{-5, 0.5}});  // z = 8 / 4 - 5
  EXPECT_DOUBLE_EQ(scale_.part(0, VectorXd{{100}}), 3 / (30.0 + free_(0)));
  EXPECT_DOUBLE_EQ(scale_.part(1, VectorXd{{100}}), 0.75 / (18.0 + free_(1)));
}

}  // namespace
}  // namespace stillframe::controller
