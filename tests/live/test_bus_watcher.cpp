#include <random>

#include "tests/live/watched.hpp"

namespace stillframe::live {
namespace {

using stillframe_msgs::run_state_t;

class BusWatcherTest : public Watched {};

TEST_F(BusWatcherTest, ARunThatBeganBeforeHasNumbersForNames) {
  hear_samples(7, 31'000, 31'100);
  ASSERT_TRUE(watcher.run());
  EXPECT_EQ(watcher.run()->names.source, RunNames::Source::none);
  EXPECT_EQ(watcher.run()->names.frame, (std::vector<std::string>{"frame 1", "frame 2"}));
  EXPECT_EQ(watcher.run()->samples->sample_rate_hz(), 1000);
  EXPECT_EQ(watcher.run()->samples->n_missed(), 0);  // what was before the watch is not missed
  EXPECT_TRUE(says(view(), "--scene FILE"));
}

/// By the clock the plant repeats its description.
TEST_F(BusWatcherTest, ADescriptionThatComesLaterGivesTheNames) {
  hear_samples(7, 31'000, 31'100);
  hear_info(7);
  hear_samples(7, 31'101, 31'200);
  EXPECT_EQ(watcher.run()->names.legs, (std::vector<std::string>{"leg_1", "leg_2"}));
  EXPECT_EQ(watcher.run()->names.force_limit_n, 200);
  EXPECT_EQ(watcher.run()->samples->motion().size(), 201);  // nothing was thrown away for it
}

TEST_F(BusWatcherTest, ASceneGivesNamesUntilTheDescriptionComes) {
  RunNames names = names_of(sample::info(7));
  names.source = RunNames::Source::scene;
  names.legs = {"a", "b"};
  watcher = BusWatcher({.run_id = {}, .names = names}, now);
  hear_samples(7, 100, 200);
  EXPECT_EQ(watcher.run()->names.legs, names.legs);
  EXPECT_EQ(watcher.run()->names.axes.size(), 1u);
  hear_info(7);
  EXPECT_EQ(watcher.run()->names.legs.front(), "leg_1");
}

TEST_F(BusWatcherTest, ASceneOfOtherSizesIsGivenUp) {
  RunNames names = names_of(sample::info(7));
  names.source = RunNames::Source::scene;
  names.legs = {"a"};
  watcher = BusWatcher({.run_id = {}, .names = names}, now);
  hear_samples(7, 100, 200);
  EXPECT_EQ(watcher.run()->names.source, RunNames::Source::none);
  ASSERT_TRUE(watcher.run()->samples);
  EXPECT_TRUE(says(view(), "the scene that was given has other numbers"));
}

TEST_F(BusWatcherTest, ANewRunTakesThePlaceOfTheOld) {
  hear_info(7);
  hear_samples(7, 0, 100);
  hear(channels::status, sample::status(7));
  hear(channels::run_state, sample::state(7, "plant", run_state_t::ENDED));
  hear_info(8);
  EXPECT_EQ(run_id(), 8);
  EXPECT_FALSE(watcher.run()->samples);
  EXPECT_TRUE(watcher.run()->controllers.empty());
  hear_samples(8, 0, 10);
  EXPECT_EQ(watcher.run()->samples->motion().size(), 11);
  EXPECT_EQ(traffic(channels::measurement).n_other_run, 0);
}

TEST_F(BusWatcherTest, ARunWithoutDescriptionIsTakenOnceTheOldIsQuiet) {
  hear_samples(7, 0, 100);
  hear_samples(8, 0, 10);
  EXPECT_EQ(run_id(), 7);
  EXPECT_EQ(traffic(channels::measurement).n_other_run, 11);
  EXPECT_EQ(watcher.other_run(), 8);
  now += 1100 * sample::ms;
  hear_samples(8, 11, 20);
  EXPECT_EQ(run_id(), 8);
}

/// Two plants by the clock on one bus: both describe themselves again and again.
TEST_F(BusWatcherTest, TwoRunsAtOnceDoNotTakeTurns) {
  int n_changes = 0;
  std::int64_t watched = 0;
  for (std::int64_t k = 0; k < 100; ++k) {
    for (const std::int64_t run : {7, 8}) {
      if (k % 10 == 0) hear_info(run);
      hear_samples(run, k, k);
      hear(channels::status, sample::status(run));
      if (run_id() != watched) ++n_changes;
      watched = run_id();
    }
  }
  EXPECT_EQ(n_changes, 2);  // 7, and 8 as it announces itself
  EXPECT_EQ(run_id(), 8);
  EXPECT_TRUE(says(view(), "another run is heard as well, 7"));
}

/// A controller that stays alive without its plant must not hide the run that is measured.
TEST_F(BusWatcherTest, AControllerAloneDoesNotHoldTheWatch) {
  hear(channels::status, sample::status(7));
  for (int i = 0; i < 20; ++i) {
    now += 100 * sample::ms;
    hear(channels::status, sample::status(7));
  }
  hear_samples(8, 500, 600);
  EXPECT_EQ(run_id(), 8);
  for (int i = 0; i < 20; ++i) {
    now += 100 * sample::ms;
    hear(channels::status, sample::status(7));
    hear_samples(8, 601 + i, 601 + i);
  }
  EXPECT_EQ(run_id(), 8);
}

TEST_F(BusWatcherTest, OnlyTheRunThatWasAskedFor) {
  watcher = BusWatcher({.run_id = 9, .names = {}}, now);
  hear_info(7);
  hear_samples(7, 0, 50);
  hear(channels::status, sample::status(7));
  EXPECT_FALSE(watcher.run());
  hear_samples(9, 0, 50);
  EXPECT_EQ(run_id(), 9);
  now += 10 * sample::second;
  hear_info(7);
  hear_samples(7, 51, 60);
  EXPECT_EQ(run_id(), 9);
}

/// stillframe-plant started by hand has run 1 each time.
TEST_F(BusWatcherTest, ARunOfTheSameNumberBeginsAgain) {
  hear_info(1);
  hear_samples(1, 0, 5000);
  hear(channels::run_state, sample::state(1, "plant", run_state_t::ENDED));
  EXPECT_TRUE(watcher.run()->over());
  hear_samples(1, 0, 100);  // its description was not heard
  EXPECT_FALSE(watcher.run()->over());
  EXPECT_EQ(watcher.run()->samples->seq(), 100);
  EXPECT_LE(watcher.run()->samples->motion().size(), 101);
  hear(channels::run_state, sample::state(1, "plant", run_state_t::ENDED));
  hear_info(1);
  EXPECT_FALSE(watcher.run()->samples);
}

/// A plant that was killed and came back for the same run, here of another scene.
class PlantThatCameBack : public BusWatcherTest {
 protected:
  void describe(std::int64_t plant, const char* scene, double rate_hz = sample::rate_hz) {
    auto info = sample::info(7);
    info.plant_instance = plant;
    info.scene_name = scene;
    info.sample_rate_hz = rate_hz;
    hear(channels::run_info, info);
  }
  void measure(std::int64_t plant, std::int64_t begin, std::int64_t end) {
    for (std::int64_t seq = begin; seq < end; ++seq) {
      now += sample::ms;
      auto measurement = sample::measurement(7, seq);
      measurement.plant_instance = plant;
      hear(channels::measurement, measurement);
      auto command = sample::command(7, seq);
      command.plant_instance = plant;
      hear(channels::command, command);
    }
  }
};

/// However early the first one was killed: 10 samples of it would go on with the next one's 11th.
TEST_F(PlantThatCameBack, IsShownByItselfAndTheOneBeforeIsSaid) {
  for (const std::int64_t killed_at : {10, 5000}) {
    watcher = BusWatcher({}, now);
    describe(1, "before");
    measure(1, 0, killed_at);
    hear(channels::status, sample::status(7));
    now += 700 * sample::ms;
    describe(2, "after");
    auto waiting = sample::state(7, "plant", run_state_t::WAITING);
    waiting.plant_instance = 2;
    hear(channels::run_state, waiting);
    measure(2, 0, 300);
    EXPECT_EQ(watcher.run()->info->scene_name, "after");
    EXPECT_EQ(watcher.run()->samples->motion().size(), 281);  // since it was believed, the 20th
    EXPECT_EQ(watcher.run()->samples->n_missed(), 0);
    EXPECT_EQ(watcher.run()->controllers.size(), 1u);
    ASSERT_TRUE(watcher.run()->plant_state);
    EXPECT_EQ(watcher.run()->plant_state->plant_instance, 2);
    EXPECT_TRUE(says(view(), "came back: " + std::to_string(killed_at) +
                                 " samples were heard of the one before and are no longer shown, "
                                 "281 of this one"));
    // One that was on its way for long; the next ones of this plant are below it.
    auto late = sample::command(7, 600);
    late.plant_instance = 1;
    hear(channels::command, late);
    measure(2, 300, 310);
    EXPECT_EQ(watcher.run()->samples->force().size(), 291);
  }
}

/// One that finds its number taken goes again, and what it said is not of the run.
TEST_F(PlantThatCameBack, IsNotOneThatGoes) {
  describe(1, "the run");
  measure(1, 0, 1000);
  describe(2, "another");
  for (std::int64_t seq = 0; seq < 30; ++seq) {
    measure(2, seq, seq + 1);
    measure(1, 1000 + seq, 1001 + seq);
  }
  auto failed = sample::state(7, "plant", run_state_t::FAILED);
  failed.plant_instance = 2;
  hear(channels::run_state, failed);
  EXPECT_FALSE(watcher.run()->over());
  EXPECT_EQ(watcher.run()->info->scene_name, "the run");
  EXPECT_EQ(watcher.run()->samples->motion().size(), 1030);
  EXPECT_EQ(watcher.run()->samples->force().size(), 1030);
  EXPECT_FALSE(says(view(), "came back"));
}

/// By the clock the description is repeated, by lock step it may not have been heard.
TEST_F(PlantThatCameBack, HasNoNamesOfTheOneBefore) {
  describe(1, "before");
  measure(1, 0, 100);
  measure(2, 0, 100);
  EXPECT_FALSE(watcher.run()->info);
  EXPECT_EQ(watcher.run()->names.source, RunNames::Source::none);
  describe(2, "after");
  EXPECT_EQ(watcher.run()->info->scene_name, "after");
}

TEST_F(BusWatcherTest, MeasurementsOfAnotherSizeAreCountedAndNotUsed) {
  hear_info(7);
  hear_samples(7, 0, 10);
  auto message = sample::measurement(7, 11);
  message.n_frame = 1;
  message.frame_acceleration = {0};
  for (int i = 0; i < 50; ++i) hear(channels::measurement, message);
  EXPECT_EQ(traffic(channels::measurement).n_wrong_size, 50);
  EXPECT_EQ(watcher.run()->samples->seq(), 10);
  EXPECT_TRUE(says(view(), "50 messages of another size on SF_MEASUREMENT"));
}

/// Without a description the first message says what the sizes are; it may have been the odd one.
TEST_F(BusWatcherTest, TheFirstSizeIsGivenUpForTenOfAnother) {
  auto odd = sample::measurement(7, 0);
  odd.n_frame = 1;
  odd.frame_acceleration = {0};
  hear(channels::measurement, odd);
  hear_samples(7, 1, 9);
  EXPECT_EQ(watcher.run()->samples->n_frame(), 1);
  hear_samples(7, 10, 30);
  EXPECT_EQ(watcher.run()->samples->n_frame(), 2);
  EXPECT_EQ(watcher.run()->names.frame.size(), 2u);
}

TEST_F(BusWatcherTest, EveryCutIsCountedAsDamaged) {
  hear_info(7);
  hear_samples(7, 0, 0);
  const std::string whole = sample::encoded(sample::measurement(7, 1));
  for (std::size_t n = 0; n < whole.size(); ++n) {
    watcher.take(channels::measurement, std::string_view(whole).substr(0, n), now);
  }
  EXPECT_EQ(traffic(channels::measurement).n_broken, static_cast<std::int64_t>(whole.size()));
  EXPECT_EQ(watcher.run()->samples->seq(), 0);
  watcher.take(channels::measurement, whole, now);
  EXPECT_EQ(watcher.run()->samples->seq(), 1);
}

TEST_F(BusWatcherTest, AnotherVersionOfATypeIsSaidToBeOne) {
  hear_info(7);
  hear(channels::measurement, sample::status(7));
  EXPECT_EQ(traffic(channels::measurement).n_other_version, 1);
  EXPECT_TRUE(says(view(), "1 messages of another version of the type on SF_MEASUREMENT"));
}

/// Damage of every kind on every channel, with a fixed seed: nothing throws, and after it a sound
/// run is seen as ever.
TEST_F(BusWatcherTest, NoDamageBreaksIt) {
  hear_info(7);
  hear_samples(7, 0, 3);
  const std::vector<std::pair<const char*, std::string>> messages = {
      {channels::measurement, sample::encoded(sample::measurement(7, 4))},
      {channels::command, sample::encoded(sample::command(7, 4))},
      {channels::run_info, sample::encoded(sample::info(7))},
      {channels::run_state, sample::encoded(sample::state(7, "plant", 2, "words"))},
      {channels::timing, sample::encoded(sample::timing(7, "plant"))},
      {channels::status, sample::encoded(sample::status(7))},
      {channels::loop,
       sample::encoded(sample::records(7, {sample::record(5, 6, 7), sample::record(8, 9, 10)}))}};
  std::mt19937_64 random(20261121);
  for (int i = 0; i < 20'000; ++i) {
    auto [channel, bytes] = messages[random() % messages.size()];
    for (std::uint64_t n = 1 + random() % 4; n > 0; --n) {
      bytes[random() % bytes.size()] = static_cast<char>(random());
    }
    if (random() % 4 == 0) bytes.resize(random() % (bytes.size() + 8));
    now += sample::ms;
    watcher.take(channel, bytes, now);
    if (i % 500 == 0) view();
  }
  watcher.take("SF_MEASUREMENT", {}, now);
  now += 5 * sample::second;
  hear_info(99);
  hear_samples(99, 0, 2000);
  EXPECT_EQ(run_id(), 99);
  EXPECT_EQ(watcher.run()->samples->motion().size(), 2001);
  EXPECT_EQ(view().axes.size(), 1u);
}

TEST_F(BusWatcherTest, NamesOfChannelsCannotFillTheMemory) {
  for (int i = 0; i < 1000; ++i) watcher.take("SF_" + std::to_string(i), "x", now);
  watcher.take(std::string(1 << 20, 'a'), "x", now);
  EXPECT_LE(watcher.channels().size(), 33u);
  EXPECT_EQ(watcher.channels().find("other channels")->second.rate.n(), 1001 - 32);
  for (int i = 0; i < 1000; ++i) hear(channels::status, sample::status(7, i));
  EXPECT_LE(watcher.run()->controllers.size(), 8u);
}

}  // namespace
}  // namespace stillframe::live
