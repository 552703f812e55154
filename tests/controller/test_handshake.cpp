#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "controller/handshake.hpp"
#include "msgs/clock.hpp"
#include "tests/controller/fake_plant.hpp"
#include "tests/controller/toy_plant.hpp"

namespace stillframe::controller {
namespace {

using stillframe_msgs::run_info_t;

struct Change {
  const char* name;
  std::function<void(run_info_t&)> apply;
  const char* key;  // that the message must name
};

class Disagreement : public testing::TestWithParam<Change> {};

TEST_P(Disagreement, IsNamed) {
  const Gains gains = toy::gains(5);
  run_info_t info = toy::run_info(gains, 1, "lock_step", 100);
  EXPECT_EQ(disagreement(gains, info), "");
  GetParam().apply(info);
  const std::string text = disagreement(gains, info);
  EXPECT_NE(text.find(GetParam().key), std::string::npos) << text;
}

INSTANTIATE_TEST_SUITE_P(
    Fields, Disagreement,
    testing::Values(Change{"format", [](run_info_t& i) { i.format_version = 2; }, "format_version"},
                    Change{"hash", [](run_info_t& i) { i.scene_hash = "ffff"; }, "scene_hash"},
                    Change{"legs", [](run_info_t& i) { std::swap(i.leg_names[0], i.leg_names[1]); },
                           "legs"},
                    Change{"rate", [](run_info_t& i) { i.sample_rate_hz = 999; }, "sample_rate_hz"},
                    Change{"delay", [](run_info_t& i) { i.delay_samples = 0; }, "delay_samples"},
                    Change{"mode", [](run_info_t& i) { i.mode = "fast"; }, "mode"},
                    Change{"loop", [](run_info_t& i) { i.loop = "open"; }, "loop"},
                    Change{"samples", [](run_info_t& i) { i.n_samples = 0; }, "run_info"},
                    Change{"sizes", [](run_info_t& i) { i.n_floor = -1; }, "run_info"}),
    [](const auto& test) { return test.param.name; });

TEST(Handshake, WallClockNeedsADelay) {
  const Gains gains = toy::gains(5, 1000, 0);
  EXPECT_EQ(disagreement(gains, toy::run_info(gains, 1, "lock_step", 100)), "");
  EXPECT_NE(disagreement(gains, toy::run_info(gains, 1, "wall_clock", 100)), "");
}

TEST(Handshake, ARunBeginsWithinSecondsOrHasBegun) {
  const std::int64_t now = 500 * ns_per_s;
  for (const std::int64_t start : {std::int64_t{0}, std::int64_t{1}, now, now + ns_per_s / 10}) {
    EXPECT_EQ(unsound_start(start, start, now), "") << start;
  }
  // Of a host that has been up for longer than this one.
  EXPECT_EQ(unsound_start(now, -5 * ns_per_s, now), "");
  for (const std::int64_t start :
       {now + 60 * ns_per_s, std::int64_t{-1}, std::numeric_limits<std::int64_t>::max(),
        std::numeric_limits<std::int64_t>::min()}) {
    EXPECT_NE(unsound_start(start, start, now).find(std::to_string(start)), std::string::npos);
  }
}

}  // namespace
}  // namespace stillframe::controller
