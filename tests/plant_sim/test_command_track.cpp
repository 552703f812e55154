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

TEST(Amplifier, HoldsLetsGoAndComesBackWithoutAStep) {
  Amplifier amplifier(2, 10, 0.5, 1e-3);
  EXPECT_EQ(amplifier.drive(force(3), 0), force(3));
  EXPECT_EQ(amplifier.drive(force(4), -1), force(4));
  for (int n = 1; n <= 10; ++n) EXPECT_EQ(amplifier.drive(force(4), n), force(4)) << n;
  double before = 4, steepest = 0;
  for (int n = 11; n <= 10 + 250; ++n) {
    const double now = amplifier.drive(force(4), n)(0);
    EXPECT_LT(now, before);
    steepest = std::max(steepest, before - now);
    before = now;
  }
  // Half way, by the symmetry of the curve, to its rounding; and the steepest of the curve there,
  // but for its curvature over the one sample, 1e-5 of it.
  EXPECT_NEAR(before, 2, 1e-14);
  EXPECT_NEAR(steepest, 4 * 15.0 / 8 * 1e-3 / 0.5, 1.5e-5 * 0.015);
  // Commands of 6 N come again: from 2 to 6, no faster than such a curve.
  for (int n = 1; n <= 500; ++n) {
    const double now = amplifier.drive(force(6), 0)(0);
    EXPECT_GE(now, before);
    EXPECT_LT(now - before, 4 * 15.0 / 8 * 1e-3 / 0.5 * 1.001);
    before = now;
  }
  EXPECT_EQ(before, 6);
  // A sample that is only missed is held, and the next command is taken as it is.
  EXPECT_EQ(amplifier.drive(force(6), 1), force(6));
  EXPECT_EQ(amplifier.drive(force(7), 0), force(7));
  // All the way to nothing.
  EXPECT_EQ(amplifier.drive(force(7), 10 + 500), force(0));
  EXPECT_EQ(amplifier.drive(force(7), 1'000'000), force(0));
  EXPECT_THROW(Amplifier(2, -1, 1, 1), std::invalid_argument);
  EXPECT_THROW(Amplifier(2, 1, 0, 1), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe
