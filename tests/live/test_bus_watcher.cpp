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
