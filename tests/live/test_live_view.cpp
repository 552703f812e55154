#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "report/live/live_json.hpp"
#include "report/spectra/spectra.hpp"
#include "tests/live/watched.hpp"

namespace stillframe::live {
namespace {

using nlohmann::json;
using stillframe_msgs::controller_status_t;
using stillframe_msgs::run_state_t;

class LiveViewTest : public Watched {
 protected:
  void hear_run(std::int64_t last) {
    hear_info(7);
    hear(channels::run_state, sample::state(7, "plant", run_state_t::RUNNING));
    hear_samples(7, 0, last);
    hear(channels::status, sample::status(7));
  }
};

/// A sine of amplitude A at f has an rms of A / sqrt 2 and, in the one band that holds f, a
/// velocity of A / (sqrt 2 2 pi f).
TEST_F(LiveViewTest, LevelsOfASineAreItsClosedForm) {
  hear_run(20'000);
  const LiveView v = view();
  EXPECT_DOUBLE_EQ(v.window_s, 16);
  EXPECT_TRUE(v.compared);
  ASSERT_EQ(v.axes.size(), 1u);
  ASSERT_TRUE(v.axes[0].floor);
  const std::pair<const SignalView*, double> signals[] = {
      {&*v.axes[0].floor, sample::floor_amplitude}, {&v.axes[0].frame, sample::lens_amplitude}};
  for (const auto& [signal, amplitude] : signals) {
    const double rms = amplitude / std::numbers::sqrt2;
    // The window's three bins lie 1/16 Hz apart: their weights 1/6, 2/3, 1/6 over f^2 differ from
    // 1/f^2 by (1/16 / 10)^2, and the mean over a whole number of periods is rounding.
    EXPECT_NEAR(signal->level.rms_acceleration, rms, 1e-9 * rms);
    EXPECT_NEAR(signal->level.largest_band_velocity, rms / (2 * std::numbers::pi * sample::sine_hz),
                1e-4 * signal->level.largest_band_velocity);
    EXPECT_EQ(signal->level.largest_band_hz, 10);
    EXPECT_NEAR(signal->level.peak_acceleration, amplitude, 1e-12 * amplitude);
    EXPECT_EQ(signal->band_velocity.size(), 20);
  }
  // 22.5 and 5.63 um/s: below the lines of 25 and of 6.25.
  EXPECT_EQ(v.axes[0].floor->level.vibration_class, "VC-B");
  EXPECT_EQ(v.axes[0].frame.level.vibration_class, "VC-D");
}

/// What is old goes: after 16 s of nothing a quake is over.
TEST_F(LiveViewTest, TheWindowForgets) {
  hear_run(20'000);
  for (std::int64_t seq = 20'001; seq <= 36'001; ++seq) {
    auto still = sample::measurement(7, seq);
    still.floor_acceleration = {0};
    still.frame_acceleration = {0, 0};
    hear(channels::measurement, still);
  }
  EXPECT_EQ(view().axes[0].floor->level.rms_acceleration, 0);
  EXPECT_EQ(view().axes[0].floor->level.vibration_class, "VC-G");
}

TEST_F(LiveViewTest, BeforeThereAre16SecondsItIsSaidOverHowMuch) {
  hear_run(899);
  EXPECT_EQ(view().window_s, 0);  // less than a second
  EXPECT_TRUE(view().axes.empty());
  hear_samples(7, 900, 3212);
  EXPECT_DOUBLE_EQ(view().window_s, 3.2);  // 3200 is the largest length that is quick to transform
  EXPECT_FALSE(view().axes.empty());
}

TEST_F(LiveViewTest, LegsAreOfTheCommandsAndTheirLimit) {
  hear_run(20'000);
  const LiveView v = view();
  ASSERT_EQ(v.legs.size(), 2u);
  EXPECT_EQ(v.legs[0].leg, "leg_1");
  EXPECT_DOUBLE_EQ(v.legs[0].rms, 30);
  EXPECT_DOUBLE_EQ(v.legs[0].peak, 30);
  EXPECT_DOUBLE_EQ(*v.legs[0].share, 0.15);
  EXPECT_DOUBLE_EQ(v.legs[1].rms, 50);
  EXPECT_DOUBLE_EQ(*v.legs[1].share, 0.25);
  EXPECT_EQ(v.force_limit_n, 200);
}

TEST_F(LiveViewTest, HistoriesAreTheRmsOfEachHalfSecond) {
  hear_run(70'000);
  const HistoryView& history = view().history;
  ASSERT_EQ(history.time_s.size(), RunSamples::n_buckets - 1);  // without that which is not over
  EXPECT_DOUBLE_EQ(history.time_s.back(), 70);
  ASSERT_EQ(history.axes.size(), 1u);
  // Five whole periods a bucket.
  const double rms = sample::lens_amplitude / std::numbers::sqrt2;
  for (std::size_t i = 0; i < 119; ++i) EXPECT_NEAR(history.axes[0].frame[i], rms, 1e-12 * rms);
  EXPECT_EQ(history.force[50], 50);
}

TEST_F(LiveViewTest, WithoutNamesEverySignalStandsAlone) {
  hear_samples(7, 100, 4000);
  const LiveView v = view();
  EXPECT_FALSE(v.compared);
  ASSERT_EQ(v.axes.size(), 3u);
  EXPECT_EQ(v.axes[0].axis, "floor 1");
  EXPECT_EQ(v.axes[2].axis, "frame 2");
  EXPECT_FALSE(v.axes[2].floor);
  EXPECT_NEAR(v.axes[2].frame.level.rms_acceleration, sample::lens_amplitude / std::numbers::sqrt2,
              1e-3 * sample::lens_amplitude);  // not a whole number of periods in the window
  EXPECT_FALSE(v.legs[0].share);
}

TEST_F(LiveViewTest, TheControllerIsWhatItSays) {
  hear_run(100);
  hear(channels::loop, sample::records(7, {sample::record(now, 90'000, 7000)}));
  const LiveView v = view();
  ASSERT_TRUE(v.controller);
  const ControllerView& c = *v.controller;
  EXPECT_EQ(c.state, "active");
  EXPECT_EQ(c.fault, "none");
  EXPECT_EQ(c.n_periods, 1001);
  EXPECT_EQ(c.n_late, 1002);
  EXPECT_EQ(c.n_lost, 1003);
  EXPECT_EQ(c.n_missing, 1004);
  EXPECT_EQ(c.n_saturated, 1005);
  EXPECT_EQ(c.n_faults, 1006);
  EXPECT_EQ(c.n_rejoins, 1007);
  EXPECT_EQ(c.n_dropped, 1008);
  EXPECT_DOUBLE_EQ(c.worst_wake_up_us, 187.2);
  EXPECT_DOUBLE_EQ(c.worst_compute_us, 30.4);
  EXPECT_DOUBLE_EQ(*c.recent_wake_up_us, 90);
  EXPECT_DOUBLE_EQ(*c.recent_compute_us, 7);
  EXPECT_TRUE(v.notes.empty()) << v.notes[0];  // a run in which all is well
}

TEST_F(LiveViewTest, SaysWhatAPersonShouldKnow) {
  EXPECT_TRUE(says(view(), "nothing heard for 0 s on udpm://a.bus"));
  hear_run(100);
  now += 3 * sample::second;
  EXPECT_TRUE(says(view(), "no measurement for 3 s"));
  EXPECT_TRUE(says(view(), "the controller has said nothing for 3 s"));
  auto status = sample::status(7);
  status.state = controller_status_t::FAULT;
  status.fault = 6;
  status.latched = 1;
  hear(channels::status, status);
  hear(channels::status, sample::status(7, 2));
  EXPECT_TRUE(says(view(), "2 controllers serve this run"));
  hear(channels::status, status);
  EXPECT_TRUE(says(view(), "latched fault (restless); `stillframe ctl reset`"));
  hear_samples(7, 111, 111);
  EXPECT_TRUE(says(view(), "10 measurements never came here"));
  hear(channels::run_state, sample::state(7, "controller", run_state_t::FAILED, "no real time"));
  EXPECT_TRUE(says(view(), "the controller has failed: no real time"));
  hear(channels::run_state, sample::state(7, "plant", run_state_t::FAILED, "it fell over"));
  EXPECT_TRUE(says(view(), "the run is over (failed: it fell over)"));
}

/// The number stays, the note goes with the samples that are missing.
TEST_F(LiveViewTest, WhatWasMissedLongAgoIsNoNews) {
  hear_run(100);
  hear_samples(7, 103, 103 + 15'999);
  EXPECT_TRUE(says(view(), "2 measurements never came here"));
  hear_samples(7, 103 + 16'000, 103 + 16'000);
  EXPECT_FALSE(says(view(), "never came here"));
  EXPECT_EQ(view().n_missed, 2);
}

TEST_F(LiveViewTest, AClockRunWithoutControllerIsSaidToHaveNone) {
  hear_info(7);
  hear_samples(7, 0, 2500);
  EXPECT_TRUE(says(view(), "no controller of this run says anything"));
}

/// docs/live.md is the reference of the keys.
void expect_documented(const json& value, const std::string& docs) {
  if (value.is_object()) {
    for (const auto& [key, part] : value.items()) {
      EXPECT_NE(docs.find("`" + key + "`"), std::string::npos) << key;
      expect_documented(part, docs);
    }
  }
  if (value.is_array() && !value.empty()) expect_documented(value.front(), docs);
}

TEST_F(LiveViewTest, JsonHasTheViewAndItsKeysAreDocumented) {
  hear_run(20'000);
  hear(channels::loop, sample::records(7, {sample::record(now, 90'000, 7000)}));
  hear(channels::timing, sample::timing(7, "plant"));
  const LiveView v = view();
  const std::string line = to_json(v, true);
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const json document = json::parse(line);
  EXPECT_EQ(document["format"], 2);
  EXPECT_EQ(document["run"]["run_id"], "7");
  EXPECT_EQ(document["run"]["names"], "run_info");
  EXPECT_EQ(document["run"]["duration_s"], 60.001);
  EXPECT_EQ(document["controller"]["n_lost"], 1003);
  // To the bit.
  EXPECT_EQ(document["axes"][0]["floor"]["rms_m_s2"], v.axes[0].floor->level.rms_acceleration);
  EXPECT_EQ(document["axes"][0]["frame"]["third_octaves_m_s"][10],
            v.axes[0].frame.band_velocity(10));
  EXPECT_EQ(document["legs"][1]["share"], 0.25);
  EXPECT_EQ(document["timing"][0]["n_lost"], 4);
  EXPECT_EQ(document["history"]["wake_up_us"].size(), 60u);
  EXPECT_TRUE(document["history"]["wake_up_us"][0].is_null());
  EXPECT_EQ(document["history"]["criteria"].size(), 7u);
  std::ifstream file(STILLFRAME_SOURCE_DIR "/docs/live.md");
  std::stringstream docs;
  docs << file.rdbuf();
  expect_documented(document, docs.str());

  const json plain = json::parse(to_json(v, false));
  EXPECT_EQ(plain["run"]["run_id"], "7");
  EXPECT_FALSE(plain.contains("history"));
  EXPECT_EQ(plain.size() + 1, document.size());
}

TEST_F(LiveViewTest, JsonOfNothingIsJsonToo) {
  const json document = json::parse(to_json(view(), true));
  EXPECT_TRUE(document["run"].is_null());
  EXPECT_TRUE(document["controller"].is_null());
  EXPECT_TRUE(document["axes"].empty());
}

TEST_F(LiveViewTest, NamesThatAreNoUtf8DoNotBreakTheJson) {
  auto info = sample::info(7);
  info.scene_name = "A \xff scene \"with\" <b>quotes</b>\n";
  hear(channels::run_info, info);
  const json document = json::parse(to_json(view(), true));
  EXPECT_EQ(document["run"]["scene"], "A \xEF\xBF\xBD scene \"with\" <b>quotes</b>\n");
}

}  // namespace
}  // namespace stillframe::live
