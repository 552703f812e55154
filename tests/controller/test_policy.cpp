#include <gtest/gtest.h>

#include <set>
#include <string>

#include "controller/policy.hpp"
#include "core/yaml/reader.hpp"
#include "tests/controller/policy_fields.hpp"

namespace stillframe::controller {
namespace {

Policy parse(const std::string& text) { return parse_policy(text, "policy.yaml", 1000); }

std::string error_of(const std::string& text) {
  try {
    parse(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Policy, ANewOneHasTheDefaults) { EXPECT_EQ(fields(parse("{}")), fields(Policy{})); }

TEST(Policy, TheDefaultFileStatesTheDefaults) {
  const Policy policy = read_policy(STILLFRAME_SOURCE_DIR "/config/policies/default.yaml", 1000);
  EXPECT_EQ(fields(policy), fields(Policy{}));
}

TEST(Policy, EveryKeyReachesItsOwnField) {
  const Policy policy = parse(R"(
start: on_request
arming: {duration_s: 0.25, require_motion: false, offset_limit_n: 7}
ramp: {in_s: 2, out_s: 3}
measurements: {hold_periods: 4, fade_s: 5, missing_part: 0.125, late_periods: 2.5,
  sigma_limit_n: 8}
watch: {limited_part: 0.0625, disobeyed_part: 0.03125}
rejoin: {a_minute: 12}
limits: {force_n: 22, rate_n_per_s: 13, free_rate_n_per_s: 16, power_w: 14, actuator_stiffness_n_per_m: 15}
realtime: {mode: enforce, priority: 18, cpu: 19}
flight_record: {duration_s: 21}
)");
  const Policy wanted{.start_at_once = false,
                      .arming_s = 0.25,
                      .require_motion = false,
                      .offset_limit_n = 7,
                      .ramp_in_s = 2,
                      .ramp_out_s = 3,
                      .hold_periods = 4,
                      .fade_s = 5,
                      .missing_part = 0.125,
                      .late_periods = 2.5,
                      .sigma_limit_n = 8,
                      .rejoins_a_minute = 12,
                      .limited_part = 0.0625,
                      .disobeyed_part = 0.03125,
                      .force_limit_n = 22,
                      .rate_limit_n_per_s = 13,
                      .free_rate_n_per_s = 16,
                      .power_limit_w = 14,
                      .actuator_stiffness_n_per_m = 15,
                      .realtime = Policy::Realtime::enforce,
                      .priority = 18,
                      .cpu = 19,
                      .record_s = 21};
  EXPECT_EQ(fields(policy), fields(wanted));
}

TEST(Policy, TheWordsOfTheChoices) {
  EXPECT_TRUE(parse("start: at_once").start_at_once);
  EXPECT_FALSE(parse("start: on_request").start_at_once);
  EXPECT_EQ(parse("realtime: {mode: off}").realtime, Policy::Realtime::off);
  EXPECT_EQ(parse("realtime: {mode: best_effort}").realtime, Policy::Realtime::best_effort);
  EXPECT_EQ(parse("realtime: {mode: enforce}").realtime, Policy::Realtime::enforce);
}

TEST(Policy, ErrorsSayWhereWhatAndWhatIsAllowed) {
  EXPECT_EQ(error_of("strat: at_once"),
            "policy.yaml:1:1: strat: unknown key (did you mean 'start'?); allowed: start, arming, "
            "ramp, measurements, watch, rejoin, limits, realtime, flight_record, excitation");
  EXPECT_EQ(error_of("ramp:\n  on_s: 1\n"),
            "policy.yaml:2:3: ramp.on_s: unknown key (did you mean 'in_s'?); allowed: in_s, out_s");
  EXPECT_EQ(error_of("start: soon"),
            "policy.yaml:1:8: start: found 'soon', allowed is one of at_once, on_request");
  EXPECT_EQ(error_of("ramp:\n  in_s: 0\n"),
            "policy.yaml:2:9: ramp.in_s: found '0', allowed is a number from 0.01 to 60");
  EXPECT_EQ(error_of("measurements:\n  hold_periods: 101\n"),
            "policy.yaml:2:17: measurements.hold_periods: found '101', allowed is a whole number "
            "from 0 to 100");
  EXPECT_EQ(error_of("measurements: {missing_part: 1.5}"),
            "policy.yaml:1:30: measurements.missing_part: found '1.5', allowed is a number above 0 "
            "and up to 1");
  EXPECT_EQ(error_of("arming: {offset_limit_n: -1}"),
            "policy.yaml:1:26: arming.offset_limit_n: found '-1', allowed is a number above 0 "
            "and up to 1e+12");
  EXPECT_EQ(error_of("measurements: {fade_s: 1 s}"),
            "policy.yaml:1:24: measurements.fade_s: found '1 s', allowed is a finite number "
            "without a unit (SI units are understood)");
}

TEST(Policy, ASlowLoopTakesAsManySamplesAsOneOf200Hz) {
  for (const double rate_hz : {200.0, 1000.0, 1e6}) {
    EXPECT_EQ(fields(default_policy(rate_hz)), fields(Policy{})) << rate_hz;
  }
  Policy slow;
  slow.arming_s = 10;
  slow.ramp_in_s = slow.ramp_out_s = slow.fade_s = 20;
  slow.record_s = 200;
  slow.excitation.window_s = 40;
  EXPECT_EQ(fields(default_policy(10)), fields(slow));
  EXPECT_EQ(fields(parse_policy("{}", "policy.yaml", 10)), fields(slow));
  slow.fade_s = 3;
  EXPECT_EQ(fields(parse_policy("measurements: {fade_s: 3}", "policy.yaml", 10)), fields(slow));
}

TEST(Policy, DefaultsAreAllowedAtEveryRate) {
  for (const double rate_hz : {1.0, 3.3, 10.0, 31.0, 32.0, 199.0, 200.0, 1000.0, 1e6}) {
    const Policy policy = default_policy(rate_hz);
    const auto digits = shortest_digits;
    const std::string text = "arming: {duration_s: " + digits(policy.arming_s) +
                             "}\nramp: {in_s: " + digits(policy.ramp_in_s) +
                             ", out_s: " + digits(policy.ramp_out_s) +
                             "}\nmeasurements: {fade_s: " + digits(policy.fade_s) +
                             "}\nflight_record: {duration_s: " + digits(policy.record_s) + "}\n";
    EXPECT_EQ(fields(parse_policy(text, "policy.yaml", rate_hz)), fields(policy)) << text;
  }
}

TEST(Policy, WhatIsTooShortForASlowLoopIsRefused) {
  const auto error = [](const std::string& text, double rate_hz) -> std::string {
    try {
      parse_policy(text, "policy.yaml", rate_hz);
    } catch (const InputError& found) {
      return found.what();
    }
    return "";
  };
  EXPECT_EQ(error("arming: {duration_s: 0.5}", 10),
            "policy.yaml:1:22: arming.duration_s: found '0.5', allowed at 10 Hz is a number from "
            "1.6 on, 16 samples");
  EXPECT_EQ(error("arming: {duration_s: 1.6}", 10), "");
  EXPECT_EQ(error("arming: {duration_s: 16}", 1), "");
  EXPECT_EQ(error("measurements: {fade_s: 0.5}", 10),
            "policy.yaml:1:24: measurements.fade_s: found '0.5', allowed at 10 Hz is a number from "
            "1 on, 10 samples");
  EXPECT_NE(error("ramp: {in_s: 0.9}", 10), "");
  EXPECT_NE(error("ramp: {out_s: 0.019}", 500), "");
  EXPECT_EQ(error("ramp: {in_s: 0.02, out_s: 0.02}", 500), "");
  EXPECT_NE(error("ramp: {in_s: 61}", 200), "");
  EXPECT_EQ(error("ramp: {in_s: 1200}", 10), "");
  EXPECT_NE(error("ramp: {in_s: 1201}", 10), "");
}

TEST(Policy, PowerAndStiffnessNeedEachOther) {
  const std::string reason =
      "found only one of power_w and actuator_stiffness_n_per_m, allowed is both or none";
  EXPECT_EQ(error_of("limits: {power_w: 10}"), "policy.yaml:1:9: limits: " + reason);
  EXPECT_EQ(error_of("limits: {actuator_stiffness_n_per_m: 1e8}"),
            "policy.yaml:1:9: limits: " + reason);
  EXPECT_EQ(error_of("limits: {rate_n_per_s: 10}"), "");
}

TEST(Policy, AFileThatIsNotThereOrNotAPolicyIsRefused) {
  EXPECT_THROW(read_policy("no_such_policy.yaml", 1000), InputError);
  EXPECT_NE(error_of("[1, 2]").find("found a sequence of 2, allowed is a map"), std::string::npos);
  EXPECT_NE(error_of("arming: now").find("arming: found 'now', allowed is a map"),
            std::string::npos);
  EXPECT_NE(error_of("start: at_once\nstart: on_request\n").find("stands twice"),
            std::string::npos);
}

TEST(Policy, EveryFaultAndDefectHasAWordOfItsOwn) {
  std::set<std::string_view> words;
  for (int i = 0; i <= static_cast<int>(Fault::limited); ++i) {
    words.insert(to_text(static_cast<Fault>(i)));
  }
  EXPECT_EQ(words.size(), 11u);
  EXPECT_FALSE(words.contains("unknown"));
  words.clear();
  for (int i = 0; i <= static_cast<int>(Defect::out_of_range); ++i) {
    words.insert(to_text(static_cast<Defect>(i)));
  }
  EXPECT_EQ(words.size(), 5u);
  EXPECT_FALSE(words.contains("unknown"));
  EXPECT_EQ(to_text(static_cast<Fault>(99)), "unknown");
}

}  // namespace
}  // namespace stillframe::controller
