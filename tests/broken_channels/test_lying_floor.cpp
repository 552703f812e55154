#include <gtest/gtest.h>

#include "core/numerics/worst.hpp"
#include "tests/broken_channels/episodes.hpp"
#include "tests/broken_channels/lying_floor.hpp"

// A feed-forward whose floor sensors lie, on the shipped frame: never worse than no loop at all.
namespace stillframe::controller {
namespace {

TEST(LyingFloor, DrivesTheFrameNoHarderThanIsPromised) {
  const Gains gains = shipped_gains("feed_forward_1khz");
  std::uint64_t seed = 1;
  for (const Lie& lie : all_lies()) {
    const LieEpisode episode = run_lie(gains, lie, seed++, usual_floor);
    EXPECT_LT(worst_of(episode.leg_force, episode.acceleration), 1.1) << lie.name;
    // A sound one isolates as it should, and is believed.
    if (lie.name == "sound") {
      EXPECT_LT(episode.acceleration, 0.2);
      EXPECT_FALSE(episode.disbelieved);
    }
  }
}

// Quiet and loud floors: what is a lie is told by the floor, and not by a number.
TEST(LyingFloor, OfAnySize) {
  const Gains gains = shipped_gains("feed_forward_1khz");
  for (const double size : {5e-4, 2e-2}) {
    const double scale = size / usual_floor;
    for (const double jump : {0.02, 0.2, 1.0}) {
      const Lie lie{"jump", [&](Lie::At& at) { at.measurement.floor(at.sensor) += scale * jump; }};
      const LieEpisode episode = run_lie(gains, lie, 4, size);
      EXPECT_LT(worst_of(episode.leg_force, episode.acceleration), 1.1) << size << " " << jump;
      EXPECT_TRUE(episode.disbelieved) << size << " " << jump;
    }
  }
}

}  // namespace
}  // namespace stillframe::controller
