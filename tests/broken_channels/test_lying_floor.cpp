#include <gtest/gtest.h>

#include <cmath>

#include "core/numerics/two_pi.hpp"
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
    // 1.1 is promised; ten seeds reach 0.28, and what is found too late or let go of too slowly 1.
    EXPECT_LT(worst_of(episode.leg_force, episode.acceleration), 0.4) << lie.name;
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

// Broken before the loop knew anything, more and more, or with measurements lost.
TEST(LyingFloor, FromTheBeginningSlowlyAndThroughGaps) {
  const Gains gains = shipped_gains("feed_forward_1khz");
  const auto swings = [](double hz, double size) {
    return Lie{"swings", [=](Lie::At& at) {
                 at.measurement.floor(at.sensor) += size * std::sin(two_pi * hz * at.t);
               }};
  };
  const Lie tenfold{"10 times", [](Lie::At& at) { at.measurement.floor(at.sensor) *= 10; }};
  const Lie grows{"grows", [](Lie::At& at) {
                    at.measurement.floor(at.sensor) +=
                        1e-4 * std::exp(at.t / 2) * std::sin(two_pi * 5 * at.t);
                  }};
  const Lie bump{"a moment of 10 m/s^2 as it begins", [](Lie::At& at) {
                   if (at.t > 1.2 && at.t < 2) at.measurement.floor(at.sensor) += 10;
                 }};
  const Lie jumps{"jump", [](Lie::At& at) { at.measurement.floor(at.sensor) += 1; }};
  const struct {
    Lie lie;
    LieTiming timing;
  } cases[] = {{tenfold, {.from_the_beginning = true}},
               {swings(5, 0.1), {.from_the_beginning = true, .early = true}},
               {swings(5, 0.3), {.from_the_beginning = true, .early = true}},
               {bump, {.from_the_beginning = true, .early = true}},
               {grows, {.lasts_s = 20}},
               {tenfold, {.lost_of_200 = 50}},
               {jumps, {.lost_of_200 = 50}}};
  std::uint64_t seed = 1;
  for (const auto& [lie, timing] : cases) {
    const LieEpisode episode = run_lie(gains, lie, seed++, usual_floor, timing);
    EXPECT_LT(worst_of(episode.leg_force, episode.acceleration), 1.1) << lie.name << " " << seed;
  }
}

}  // namespace
}  // namespace stillframe::controller
