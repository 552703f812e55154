#include <gtest/gtest.h>

#include "core/worst.hpp"
#include "tests/broken_channels/episodes.hpp"

// Whatever breaks between the sensors and the law, or between the law and the leg, of the frame as
// it is shipped: what the frame feels of it, beside the same frame left alone on the same floor.
namespace stillframe::controller {
namespace {

/// The peak that is promised, over the passive one. Before forces had a pace it was 15 to 60.
double promised(const Broken& broken) {
  // The force that an actuator holds is gone, turned or shaken at once: no command can hold it.
  if (broken.part == Part::actuator) return 4;
  // What grows slowly stays within the pace for longer, and offsets are believed: 2.1 is reached.
  const bool drifts = broken.damage == Damage::drifts || broken.damage == Damage::offset;
  const bool too_large = broken.part == Part::read_back && broken.damage == Damage::scaled;
  return drifts || (too_large && broken.size > 1) ? 2.2 : 1.1;
}

class BrokenChannels : public testing::TestWithParam<const char*> {};

TEST_P(BrokenChannels, DriveTheFrameNoHarderThanIsPromised) {
  const Gains gains = shipped_gains(GetParam());
  for (const Broken& broken : all_broken()) {
    const Episode episode = run_episode(gains, {}, {broken}, 1);
    EXPECT_LT(episode.peak, promised(broken)) << broken.name();
    EXPECT_EQ(episode.latched, episode.found_s >= 0) << broken.name();
  }
}

TEST_P(BrokenChannels, InPairs) {
  const Gains gains = shipped_gains(GetParam());
  const std::vector<Broken> all = all_broken();
  std::mt19937_64 random(9);
  double worst = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const Broken &a = all[random() % all.size()], &b = all[random() % all.size()];
    const Episode episode = run_episode(gains, {}, {a, b}, random());
    EXPECT_LT(episode.peak, std::max(promised(a), promised(b))) << a.name() << ", " << b.name();
    worst = worst_of(worst, episode.peak);
  }
  RecordProperty("worst_peak", std::to_string(worst));
}

// What cannot do its work and does harm is found at once, whichever leg it is.
TEST_P(BrokenChannels, OfASensorAreFoundWithinATwentiethOfASecond) {
  const Gains gains = shipped_gains(GetParam());
  for (const Damage damage : {Damage::swapped, Damage::reversed}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Episode episode = run_episode(gains, {}, {{Part::sensor, damage}}, seed);
      EXPECT_EQ(episode.fault, Fault::restless);
      EXPECT_GE(episode.found_s, 0);
      EXPECT_LT(episode.found_s, 0.05);
    }
  }
}

// The bench is no kinder than the figures: without a pace the same damage is worse than the
// passive frame many times over.
TEST_P(BrokenChannels, WouldDoHarmWithoutAPace) {
  Policy free;
  free.free_rate_n_per_s = 1e12;
  const Episode episode =
      run_episode(shipped_gains(GetParam()), free, {{Part::sensor, Damage::reversed}}, 1);
  EXPECT_GT(episode.peak, 5);
}

INSTANTIATE_TEST_SUITE_P(Shipped, BrokenChannels,
                         testing::Values("force_feedback_5hz", "force_feedback_5khz"),
                         [](const auto& controller) { return std::string(controller.param); });

}  // namespace
}  // namespace stillframe::controller
