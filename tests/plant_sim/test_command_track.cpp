#include <gtest/gtest.h>

#include "plant_sim/amplifier.hpp"
#include "plant_sim/command_track.hpp"

namespace stillframe {
namespace {

using Eigen::VectorXd;

VectorXd force(double value) { return VectorXd::Constant(2, value); }

TEST(CommandTrack, GivesEachCommandItsOwnSample) {
  CommandTrack track(2);
  EXPECT_EQ(track.seq(), -1);
  EXPECT_EQ(track.force(), force(0));
  // All at once, out of order, as a plant finds them that was stopped.
  for (const int seq : {3, 1, 2, 7}) {
    EXPECT_EQ(track.add(seq, force(seq)), CommandTrack::Result::taken);
  }
  EXPECT_EQ(track.add(2, force(20)), CommandTrack::Result::duplicate);
  for (int k = 0; k < 10; ++k) {
    track.advance_to(k);
    const int newest = k >= 7 ? 7 : std::min(k, 3);
    EXPECT_EQ(track.seq(), newest > 0 ? newest : -1) << k;
    EXPECT_EQ(track.force(), force(newest)) << k;
  }
  EXPECT_EQ(track.add(7, force(1)), CommandTrack::Result::duplicate);
  EXPECT_EQ(track.add(5, force(1)), CommandTrack::Result::duplicate);
  EXPECT_EQ(track.force(), force(7));
}

TEST(CommandTrack, KeepsOnlySoMany) {
  CommandTrack track(2);
  std::int64_t seq = 0;
  while (seq < 1'000'000 && track.add(seq, force(1)) == CommandTrack::Result::taken) ++seq;
  EXPECT_EQ(seq, 100'000);
  track.advance_to(10);
  EXPECT_EQ(track.add(seq, force(1)), CommandTrack::Result::taken);
}

TEST(Amplifier, HoldsAndThenLetsGoSmoothly) {
  const Amplifier amplifier(10, 0.5, 1e-3);
  for (int n = -1; n <= 10; ++n) EXPECT_EQ(amplifier.part(n), 1) << n;
  EXPECT_LT(amplifier.part(11), 1);
  // Half way, by the symmetry of the curve; to its rounding.
  EXPECT_NEAR(amplifier.part(10 + 250), 0.5, 1e-14);
  EXPECT_EQ(amplifier.part(10 + 500), 0);
  EXPECT_EQ(amplifier.part(1'000'000), 0);
  double steepest = 0;
  for (int n = 0; n < 600; ++n) {
    EXPECT_LE(amplifier.part(n + 1), amplifier.part(n));
    steepest = std::max(steepest, amplifier.part(n) - amplifier.part(n + 1));
  }
  EXPECT_NEAR(steepest, 15.0 / 8 * 1e-3 / 0.5, 1e-7);  // the steepest of the curve, at its middle
  EXPECT_THROW(Amplifier(-1, 1, 1), std::invalid_argument);
  EXPECT_THROW(Amplifier(1, 0, 1), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe
