#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "report/spectra/spectra.hpp"
#include "report/verdict/acceptance.hpp"
#include "report/verdict/motion_level.hpp"

namespace stillframe::report {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

MotionSpectra flat(double velocity) {
  return {.velocity = std::vector<double>(third_octave_bands().size(), velocity),
          .cumulative_rms = {}};
}

/// A minute of a frame that moves a tenth of what the floor does and a hundredth of what it does
/// without control, in two directions; 5 Hz is aimed at. Asked for as a scene would have it.
struct MadeUp {
  explicit MadeUp(SceneAcceptance what = {}) : accept(std::move(what)) {
    for (const char* loop : {"passive", "active"}) {
      verdict.runs.push_back({.mode = "wall_clock",
                              .loop = loop,
                              .sample_rate_hz = 1000,
                              .n_samples = 60001,
                              .n_judged = 60001,
                              .n_commands = 60001,
                              .n_commands_given = 60001,
                              .n_periods = 60001});
      verdict.timing.push_back({.loop = loop, .source = "controller"});
    }
    verdict.isolates_above_hz = 10;
    for (const char* name : {"x", "z"}) {
      verdict.axes.push_back({name, MotionLevel{.rms_acceleration = 1, .vibration_class = "VC-D"},
                              MotionLevel{.rms_acceleration = 10, .vibration_class = "VC-A"},
                              MotionLevel{.rms_acceleration = 0.1, .vibration_class = "VC-F"},
                              flat(1), flat(10), flat(0.1)});
    }
    ask();
  }
  void ask() {
    for (AxisLevels& axis : verdict.axes) {
      axis.asked = asked_of(accept, axis.axis, verdict);
      for (AskedMotion& motion : axis.asked) {
        motion.floor = 1;
        if (axis.passive) motion.passive = 10;
        if (axis.active) motion.active = 0.1;
      }
    }
  }
  Judgement judged() const { return judge(verdict, accept, prediction); }

  RunSummary& active() { return verdict.runs.back(); }
  std::vector<AskedMotion>& asked() { return verdict.axes[1].asked; }

  Verdict verdict;
  SceneAcceptance accept;
  std::vector<Check> prediction;
};

struct Change {
  const char* part;  ///< of the reason
  std::function<void(MadeUp&)> make;
};

TEST(Acceptance, FailsForEachThingThatIsNotAsItShouldBe) {
  ASSERT_EQ(MadeUp().judged().outcome, Outcome::passed) << MadeUp().judged().reason;
  EXPECT_EQ(MadeUp().judged().reason, "All 12 checks that could be made passed.");
  const Change changes[] = {
      {"damaged in 1 places", [](MadeUp& m) { m.verdict.runs[0].n_damaged = 1; }},
      {"9 bytes at its end", [](MadeUp& m) { m.active().unread_bytes = 9; }},
      {"K_P: missing", [](MadeUp& m) { m.active().unreadable = "K_P: missing"; }},
      {"1 of 60002 ", [](MadeUp& m) { m.active().n_lost = 1; }},
      {"601 of 60001 (1 %), allowed: at most 1 %", [](MadeUp& m) { m.active().n_saturated = 601; }},
      {"holds no commands",
       [](MadeUp& m) { m.active().n_commands = *(m.active().n_commands_given = 0); }},
      {"Commands that the log of the active run lacks: 6923 of 60001",
       [](MadeUp& m) { m.active().n_commands -= 6923; }},
      {"the passive run that are not finite, or beyond 1e+12 (N, m/s^2): 2, the first at seq 3, "
       "sigma of leg_1",
       [](MadeUp& m) {
         m.verdict.runs[0].n_not_finite = 2;
         m.verdict.runs[0].first_not_finite = "seq 3, sigma of leg_1";
       }},
      {"repeat the one before in every channel: 19999 of 60001",
       [](MadeUp& m) { m.active().n_repeats = 19999; }},
      {"never answered: 601 of 60001", [](MadeUp& m) { m.verdict.timing[1].n_lost = 601; }},
      {"never answered: 28455 of 60001", [](MadeUp& m) { m.active().n_unanswered = 28455; }},
      {"rejected: 16200 of 60001 (27 %)", [](MadeUp& m) { m.active().n_discarded = 16200; }},
      {"moves 1147 times as much as the passive frame",
       [](MadeUp& m) { m.asked()[0].active = 11470; }},
      {"moves 19 times as much as the floor (rms from 10 to 80 Hz)",
       [](MadeUp& m) { m.asked()[1].active = 19; }},
      {"moves nan times", [](MadeUp& m) { m.asked()[0].active = nan; }},
      {"moves nan times", [](MadeUp& m) { m.asked()[1].active = nan; }},
      {"not what was predicted",
       [](MadeUp& m) {
         m.prediction = {{.subject = Subject::prediction,
                          .what = {},
                          .asked = {},
                          .found = {},
                          .outcome = Outcome::failed,
                          .reason = "The loop is not what was predicted."}};
       }},
  };
  for (const Change& change : changes) {
    MadeUp made_up;
    change.make(made_up);
    const Judgement judgement = made_up.judged();
    EXPECT_EQ(judgement.outcome, Outcome::failed) << change.part;
    EXPECT_NE(judgement.reason.find(change.part), std::string::npos) << judgement.reason;
  }
}

TEST(Acceptance, WithoutAnythingToJudgeByNothingPasses) {
  const Change changes[] = {
      {"no run of the active loop",
       [](MadeUp& m) {
         m.verdict.runs.pop_back();
         for (AxisLevels& axis : m.verdict.axes) axis.active.reset();
         m.ask();
       }},
      {"is too short", [](MadeUp& m) { m.active().n_judged = 9000; }},
      {"No direction is compared", [](MadeUp& m) { m.verdict.axes.clear(); }},
      {"neither frame moves",
       [](MadeUp& m) {
         for (AxisLevels& axis : m.verdict.axes) {
           for (AskedMotion& motion : axis.asked) motion.floor = 0;
           axis.asked[0].passive = axis.asked[0].active = 0;
         }
       }},
  };
  for (const Change& change : changes) {
    MadeUp made_up;
    change.make(made_up);
    const Judgement judgement = made_up.judged();
    EXPECT_EQ(judgement.outcome, Outcome::not_judged) << change.part << ": " << judgement.reason;
    EXPECT_NE(judgement.reason.find(change.part), std::string::npos) << judgement.reason;
  }
  EXPECT_EQ(judge({}, {}, {}).outcome, Outcome::not_judged);
  // Too short to pass, but not to fail.
  MadeUp wild;
  wild.active().n_judged = 5000;
  wild.asked()[1].active = 11;
  EXPECT_EQ(wild.judged().outcome, Outcome::failed);
  // A floor that hardly moves where the loop isolates leaves what it does elsewhere.
  MadeUp slow;
  for (AxisLevels& axis : slow.verdict.axes) axis.asked[1].floor = 1e-4;
  EXPECT_EQ(slow.judged().outcome, Outcome::passed);
  // What nothing tells is not passed, nor is it left out.
  MadeUp silent;
  silent.verdict.timing.clear();
  silent.active().n_commands_given.reset();
  EXPECT_EQ(silent.judged().reason, "All 10 checks that could be made passed.");
  EXPECT_EQ(silent.judged().checks.size(), 12u);
  silent.accept.lost_share = 0.1;
  EXPECT_EQ(silent.judged().outcome, Outcome::not_judged);
  // Without a passive run there is the floor, and with forces on the frame there is not.
  MadeUp alone;
  alone.verdict.runs.erase(alone.verdict.runs.begin());
  for (AxisLevels& axis : alone.verdict.axes) axis.passive.reset();
  alone.ask();
  EXPECT_EQ(alone.judged().outcome, Outcome::passed);
}

// That forces are named in a scene says nothing of what they did: what the model makes of them may
// be theirs, and 0.413 of that more or less, but no noise, steps of converters and limits.
TEST(Acceptance, ForcesOnTheFrameExcuseWhatTheyMayHaveDone) {
  struct Forces {
    double by_forces, undisturbed;
  };
  const auto outcome = [](double active, std::optional<Forces> forces) {
    MadeUp alone;
    alone.verdict.runs.erase(alone.verdict.runs.begin());
    for (AxisLevels& axis : alone.verdict.axes) axis.passive.reset();
    alone.verdict.disturbed = true;
    if (!forces) alone.verdict.forces_unknown = "their file is gone";
    alone.ask();
    for (AxisLevels& axis : alone.verdict.axes) {
      axis.asked[1].active = active;
      if (!forces) continue;
      axis.asked[1].active_by_forces = forces->by_forces;
      axis.asked[1].active_undisturbed = forces->undisturbed;
    }
    return alone.judged();
  };
  EXPECT_EQ(outcome(0.5, std::nullopt).outcome, Outcome::passed);
  EXPECT_EQ(outcome(4, std::nullopt).outcome, Outcome::not_judged);
  // Nothing else passes then, as it does where it is known that they did it.
  EXPECT_TRUE(outcome(4, std::nullopt).checks.back().is_needed);
  EXPECT_FALSE(outcome(4, Forces{3.9, 0.9}).checks.back().is_needed);
  EXPECT_NE(outcome(4, std::nullopt).checks.back().reason.find("their file is gone"),
            std::string::npos);
  EXPECT_EQ(outcome(4, Forces{3.9, 0.9}).outcome, Outcome::not_judged);
  EXPECT_NE(outcome(4, Forces{3.9, 0.9}).checks.back().reason.find("forces act"),
            std::string::npos);
  EXPECT_EQ(outcome(4, Forces{1, 1.4}).outcome, Outcome::not_judged) << "1.4 - 0.413";
  EXPECT_EQ(outcome(4, Forces{1, 1.42}).outcome, Outcome::failed) << "1.42 - 0.413";
  EXPECT_EQ(outcome(4, Forces{0, 4}).outcome, Outcome::failed);
  EXPECT_EQ(outcome(4, Forces{1e-9, 4}).outcome, Outcome::failed);
  // Forces that the scene names and nobody put on: the frame without them moved as it did.
  EXPECT_EQ(outcome(4, Forces{10, std::hypot(4, 10)}).outcome, Outcome::failed);
  EXPECT_EQ(outcome(4, Forces{1, nan}).outcome, Outcome::failed);
  EXPECT_EQ(outcome(nan, Forces{0, nan}).outcome, Outcome::failed);
  // Against the passive frame nothing is excused, but what may be the reason is named.
  MadeUp softer;
  softer.verdict.disturbed = true;
  softer.ask();
  softer.asked()[0].active = 40;
  const Judgement of_softer = softer.judged();
  EXPECT_EQ(of_softer.outcome, Outcome::failed);
  EXPECT_NE(of_softer.reason.find("a softer frame gives way more."), std::string::npos)
      << of_softer.reason;
  // What a scene asks for by name it asks of all that acts.
  MadeUp named({.axes = {{.axis = "z", .rms_of_floor = 1}}});
  named.verdict.disturbed = true;
  named.ask();
  named.asked()[0].active = 4;
  EXPECT_EQ(named.judged().outcome, Outcome::failed);
}

// A sensor without a cable reads what a perfect frame does.
TEST(Acceptance, WhatRestsWhereItShouldMoveNeverPasses) {
  MadeUp sensor;
  sensor.active().resting_channels = {RestingChannel{"lens_x"}};
  sensor.verdict.axes[0].resting = "lens_x never changes";
  for (AskedMotion& asked : sensor.verdict.axes[0].asked) asked.active = 0;
  EXPECT_EQ(sensor.judged().outcome, Outcome::not_judged);
  EXPECT_NE(sensor.judged().reason.find("lens_x never changes by a bit"), std::string::npos)
      << sensor.judged().reason;
  for (const Check& check : sensor.judged().checks) {
    if (check.reason.find("Axis x") != 0) continue;
    EXPECT_EQ(check.outcome, Outcome::not_judged);
  }
  sensor.asked()[1].active = 19;
  EXPECT_EQ(sensor.judged().outcome, Outcome::failed) << "z is seen";
  MadeUp force;
  force.active().resting_forces = {RestingChannel{"leg_1"}};
  EXPECT_EQ(force.judged().outcome, Outcome::failed);
  EXPECT_NE(force.judged().reason.find("leg_1 never changes by a bit though the commands do"),
            std::string::npos);
}

// What a record's ends leave in a range is no motion: neither side may pass or fail by it.
TEST(Acceptance, EndsOfRecordsNeitherPassNorFail) {
  struct Jumps {
    double floor, active;
  };
  const auto outcome = [](double active, Jumps jumps) {
    MadeUp m;
    for (AxisLevels& axis : m.verdict.axes) {
      axis.asked[1].active = active;
      axis.asked[1].floor_jumps = jumps.floor;
      axis.asked[1].active_jumps = jumps.active;
    }
    return m.judged().checks;
  };
  const auto of_floor = [&](double active, Jumps jumps) {
    std::optional<Outcome> found;
    for (const Check& check : outcome(active, jumps)) {
      if (check.what.find("active to floor") != std::string::npos) found = check.outcome;
    }
    return found.value();
  };
  EXPECT_EQ(of_floor(0.8, {0.1, 0.05}), Outcome::passed) << "0.85 / 0.9";
  EXPECT_EQ(of_floor(0.8, {0.1, 0.11}), Outcome::not_judged) << "0.91 / 0.9";
  EXPECT_EQ(of_floor(0.8, {1, 0}), Outcome::not_judged) << "a floor that is all ends";
  EXPECT_EQ(of_floor(1.3, {0.1, 0.1}), Outcome::failed) << "1.2 / 1.1";
  EXPECT_EQ(of_floor(1.3, {0.1, 0.21}), Outcome::not_judged) << "1.09 / 1.1";
  MadeUp none;
  none.asked()[1].floor = nan;
  EXPECT_EQ(none.judged().outcome, Outcome::failed) << "a floor that is no number";
  for (AxisLevels& axis : none.verdict.axes) axis.floor->rms_acceleration = nan;
  none.asked()[0].passive = nan;
  for (const Check& check : none.judged().checks) {
    EXPECT_EQ(check.reason.find("hardly moves"), std::string::npos) << check.reason;
  }
}

// A still floor: what the active frame does there is its own loop's doing.
TEST(Acceptance, AFrameThatOnlyItsLoopShakesFails) {
  const auto judged = [](double passive, double active, AxisAcceptance asked = {}) {
    SceneAcceptance accept;
    if (asked.axis == "z") accept.axes.push_back(asked);
    MadeUp m(accept);
    for (AxisLevels& axis : m.verdict.axes) {
      for (AskedMotion& motion : axis.asked) {
        motion.floor = 0;
        motion.passive = passive;
        motion.active = active;
      }
    }
    return m.judged();
  };
  EXPECT_EQ(judged(0, 1.9).outcome, Outcome::failed);
  EXPECT_NE(judged(0, 1.9).reason.find("the passive frame rests, and the active one moves by 1.9 "
                                       "m/s^2 rms from 1 to 80 Hz, which only its own loop can do"),
            std::string::npos)
      << judged(0, 1.9).reason;
  EXPECT_EQ(judged(1e-13, 2e-9).outcome, Outcome::failed) << "rounding is rest";
  EXPECT_EQ(judged(0, nan).outcome, Outcome::failed);
  // What no instrument tells from rest is no motion, and no proof either.
  EXPECT_EQ(judged(0, 1e-10).outcome, Outcome::not_judged);
  EXPECT_EQ(judged(0, 0).outcome, Outcome::not_judged);
  // Forces shake both.
  EXPECT_EQ(judged(1, 0.5).outcome, Outcome::passed);
  EXPECT_EQ(judged(0, 1, {.axis = "z", .rms_of_passive = 0.5}).outcome, Outcome::failed);
  EXPECT_EQ(judged(0, 1, {.axis = "z", .band_of_passive = 0.5}).outcome, Outcome::failed);
}

// What moves by the second order only, as a frame above a step along x does along z: 1.4e-8 m/s^2,
// with control 1.9e-8, beside 2e-4 along x.
TEST(Acceptance, AnAxisThatHardlyMovesBesideTheLargestIsNotJudgedByDefault) {
  struct Levels {
    std::optional<double> floor, passive, active;
  };
  const auto judged = [](const Levels& x, const Levels& z, const SceneAcceptance& accept = {}) {
    MadeUp m(accept);
    if (!x.passive) m.verdict.runs.erase(m.verdict.runs.begin());
    for (AxisLevels& axis : m.verdict.axes) {
      const Levels& levels = axis.axis == "x" ? x : z;
      axis.floor->rms_acceleration = levels.floor.value_or(0);
      for (AskedMotion& motion : axis.asked) {
        motion.floor = levels.floor;
        motion.passive = levels.passive;
        motion.active = levels.active;
      }
    }
    return m.judged();
  };
  const Levels x{2e-4, 2.25e-4, 1.8e-4};
  const Judgement little = judged(x, {0, 1.4e-8, 1.9e-8});
  EXPECT_EQ(little.outcome, Outcome::passed) << little.reason;
  EXPECT_EQ(std::count_if(little.checks.begin(), little.checks.end(),
                          [](const Check& check) {
                            return check.reason.find("moves less than 0.1 % of what the largest") !=
                                   std::string::npos;
                          }),
            1);
  EXPECT_EQ(judged(x, {0, 0, 1.9e-8}).outcome, Outcome::passed) << "without control at rest";
  // A thousandth of 2.25e-4 is the limit; 3 % is a vibration.
  EXPECT_EQ(judged(x, {0, 1.4e-8, 2.2e-7}).outcome, Outcome::passed);
  EXPECT_EQ(judged(x, {0, 1.4e-8, 2.3e-7}).outcome, Outcome::failed);
  EXPECT_EQ(judged(x, {0, 0, 2.3e-7}).outcome, Outcome::failed);
  EXPECT_EQ(judged(x, {0, 1.4e-8, 0.03 * 2.25e-4}).outcome, Outcome::failed);
  EXPECT_EQ(judged(x, {0, 1.4e-8, nan}).outcome, Outcome::failed);
  // What the passive frame or the floor does there of itself is judged, ...
  EXPECT_EQ(judged(x, {0, 2.3e-7, 2.4e-7}).outcome, Outcome::failed);
  EXPECT_EQ(judged(x, {2.1e-7, 1.4e-8, 1.9e-8}).outcome, Outcome::failed);
  EXPECT_EQ(judged(x, {nan, 1.4e-8, 1.9e-8}).outcome, Outcome::failed);
  // ... and so is what stands by name, of which the scene may ask another range.
  EXPECT_EQ(judged(x, {0, 1.4e-8, 1.9e-8}, {.axes = {{.axis = "z", .rms_of_passive = 1}}}).outcome,
            Outcome::failed);
  const auto x_by_name = [](double from_hz) {
    return SceneAcceptance{
        .axes = {{.axis = "x", .from_hz = from_hz, .to_hz = 50, .rms_of_passive = 1e6}}};
  };
  EXPECT_EQ(judged(x, {0, 1.4e-8, 1.9e-8}, x_by_name(2)).outcome, Outcome::passed);
  EXPECT_EQ(judged(x, {0, 1.4e-8, 1.9e-8}, x_by_name(0.1)).outcome, Outcome::failed)
      << "what it moves below the range is nothing in it";
  // An active frame that runs away along x excuses nothing.
  EXPECT_EQ(judged({2e-4, 2.25e-4, 1}, {0, 1.4e-8, 2.3e-7}, x_by_name(2)).outcome, Outcome::failed);
  // Without a passive run it is the floor: a direction across it moves by rounding.
  EXPECT_EQ(judged({2e-4, {}, 1.8e-4}, {1e-20, {}, 1.9e-8}).outcome, Outcome::passed);
  EXPECT_EQ(judged({2e-4, {}, 1.8e-4}, {1e-20, {}, 2.1e-7}).outcome, Outcome::failed);
}

// What lies beside a range and may reach into it neither passes nor fails a run.
TEST(Acceptance, WhatIsBesideARangeNeitherPassesNorFails) {
  const auto of_floor = [](double active, double floor_leak, double active_leak) {
    MadeUp m;
    for (AxisLevels& axis : m.verdict.axes) {
      axis.asked[1].active = active;
      axis.asked[1].floor_leak = floor_leak;
      axis.asked[1].active_leak = active_leak;
    }
    Check found;
    for (const Check& check : m.judged().checks) {
      if (check.what.find("active to floor") != std::string::npos) found = check;
    }
    return found;
  };
  EXPECT_EQ(of_floor(0.8, 0.1, 0.4).outcome, Outcome::passed) << "0.894 / 0.995";
  EXPECT_EQ(of_floor(0.8, 0.1, 0.6).outcome, Outcome::not_judged) << "1 / 0.995";
  EXPECT_NE(of_floor(0.8, 0.1, 0.6).reason.find("what moves beside the range may be so much"),
            std::string::npos);
  EXPECT_EQ(of_floor(0.8, 1, 0).outcome, Outcome::not_judged) << "nothing is sure of the floor";
  EXPECT_EQ(of_floor(1.3, 0.1, 0.8).outcome, Outcome::failed) << "1.025 / 1.005";
  EXPECT_EQ(of_floor(1.3, 0.1, 0.9).outcome, Outcome::not_judged) << "0.938 / 1.005";
}

TEST(Acceptance, ARangeThatNoRecordResolvesIsNotJudged) {
  MadeUp m({.axes = {{.axis = "z", .from_hz = 5, .to_hz = 5.0001, .rms_of_floor = 0.5}}});
  m.asked()[0].narrowest_hz = 0.1;
  m.asked()[0].floor = 1e-9;  // as little as such a range has
  const Judgement judgement = m.judged();
  EXPECT_EQ(judgement.outcome, Outcome::not_judged);
  EXPECT_EQ(judgement.reason,
            "Axis z: the range from 5 to 5.0001 Hz is narrower than what the record resolves, 0.1 "
            "Hz.");
}

TEST(Acceptance, BandsThatCannotBeLookedAtSayWhy) {
  const auto judged = [](double from_hz, double to_hz,
                         const std::function<void(AxisLevels&)>& change) {
    MadeUp m({.axes = {{.axis = "z", .from_hz = from_hz, .to_hz = to_hz, .band_of_floor = 0.5}}});
    change(m.verdict.axes[1]);
    return m.judged();
  };
  const auto nothing = [](AxisLevels&) {};
  EXPECT_EQ(judged(21, 22, nothing).reason,
            "Axis z: no third-octave band has its centre from 21 to 22 Hz.");
  EXPECT_EQ(judged(20, 22, nothing).outcome, Outcome::passed);
  const auto leak = [](double floor, double active, double narrowest_hz) {
    return [=](AxisLevels& axis) {
      const std::size_t n = axis.floor_spectra->velocity.size();
      axis.floor_spectra->leak.assign(n, floor);
      axis.active_spectra->leak.assign(n, active);
      axis.floor_spectra->narrowest_hz = narrowest_hz;
    };
  };
  // 0.1 of the floor's 1: 0.4 more is 0.412, 0.6 more is 0.608.
  EXPECT_EQ(judged(20, 22, leak(0, 0.4, 0.1)).outcome, Outcome::passed);
  EXPECT_EQ(judged(20, 22, leak(0, 0.6, 0.1)).outcome, Outcome::not_judged);
  EXPECT_NE(judged(20, 22, leak(0.95, 0, 0.1)).reason.find("hardly moves in any third-octave"),
            std::string::npos);
  EXPECT_NE(judged(20, 22, leak(0.95, 0, 5))
                .reason.find("does not resolve the third-octave band "
                             "of 20 Hz"),
            std::string::npos);
}

TEST(Acceptance, AClassThatHangsOnWhatIsBesideABandIsNotJudged) {
  const auto outcome = [](double leak, const char* asked) {
    MadeUp m({.axes = {{.axis = "z", .vibration_class = asked}}});
    AxisLevels& z = m.verdict.axes[1];
    z.active->vibration_class = "VC-E";  // 3.12 um/s
    z.active_spectra = flat(3e-6);
    z.active_spectra->leak.assign(20, leak);
    return m.judged().outcome;
  };
  EXPECT_EQ(outcome(0.5e-6, "VC-E"), Outcome::passed) << "3.04";
  EXPECT_EQ(outcome(1e-6, "VC-E"), Outcome::not_judged) << "3.16";
  EXPECT_EQ(outcome(1e-6, "VC-D"), Outcome::passed);
  EXPECT_EQ(outcome(1e-6, "VC-F"), Outcome::failed) << "2.83 for 1.56";
  EXPECT_EQ(outcome(2.7e-6, "VC-F"), Outcome::not_judged) << "1.31 for 1.56";
}

TEST(Acceptance, FloorsThatMoveApartLeaveThePassiveFrame) {
  MadeUp m;
  m.verdict.floors_apart = true;
  m.ask();
  EXPECT_EQ(m.judged().outcome, Outcome::passed) << m.judged().reason;
  for (AxisLevels& axis : m.verdict.axes) axis.asked[0].active = 21;
  EXPECT_EQ(m.judged().outcome, Outcome::failed);
  MadeUp asked({.axes = {{.axis = "z", .rms_of_floor = 1}}});
  asked.verdict.floors_apart = true;
  asked.ask();
  EXPECT_EQ(asked.judged().outcome, Outcome::not_judged);
}

// At 125 Hz no band of 63 Hz and above was observed, and what was rules VC-A in and VC-E out.
// A frame with modes at 0.36 Hz or 207 Hz is judged where they are.
TEST(Acceptance, TheRangeIsThatOfTheScene) {
  const auto range = [](double lowest_hz, double highest_hz) {
    const FrequencyRange judged = judged_range({lowest_hz, highest_hz});
    return std::pair(judged.lowest_hz, judged.highest_hz);
  };
  EXPECT_EQ(range(0.5, 200), std::pair(1.0, 200.0));
  EXPECT_EQ(range(0.01, 2), std::pair(0.05, 80.0));
  EXPECT_EQ(range(2, 1000), std::pair(1.0, 1000.0));
  MadeUp m;
  m.verdict.judged = {0.2, 900};
  m.ask();
  ASSERT_EQ(m.asked().size(), 2u);
  EXPECT_EQ(m.asked()[0].asked.from_hz, 0.2);
  EXPECT_EQ(m.asked()[1].asked.from_hz, 10);
  for (const AskedMotion& motion : m.asked()) EXPECT_EQ(motion.asked.to_hz, 500);  // half the rate
  // Ten periods of 0.2 Hz are in the minute, of 0.1 Hz are not.
  EXPECT_EQ(m.judged().outcome, Outcome::passed) << m.judged().reason;
  const auto of_passive = [&] {
    for (const Check& check : m.judged().checks) {
      if (check.what.find("passive frame") != std::string::npos) return check.outcome;
    }
    return Outcome::failed;
  };
  EXPECT_EQ(of_passive(), Outcome::passed);
  m.verdict.judged = {0.1, 900};
  m.ask();
  EXPECT_EQ(of_passive(), Outcome::not_judged);
}

TEST(Acceptance, WhatAllSamplesSayIsNotContradictedSilently) {
  const auto said = [](double whole, double peak, double in_range) {
    MadeUp m;
    AxisLevels& z = m.verdict.axes[1];
    z.passive->whole_rms = z.passive->peak_acceleration = 1;
    z.active->whole_rms = whole;
    z.active->peak_acceleration = peak;
    m.asked()[0].active = in_range * *m.asked()[0].passive;
    return worse_over_all(z);
  };
  EXPECT_EQ(said(0.5, 0.9, 0.5), "");
  EXPECT_NE(said(2.06, 0.9, 0.64).find("2.06 times as much as the passive one by rms"),
            std::string::npos);
  EXPECT_NE(said(0.9, 1.5, 0.64).find("1.5 times by peak"), std::string::npos);
  EXPECT_EQ(said(2.06, 2, 2.06), "");  // a check says so
}

/// No check fails by it, and no pass keeps it to itself.
TEST(Acceptance, APassSaysWhereTheClassGetsWorse) {
  MadeUp m;
  EXPECT_EQ(m.judged().outcome, Outcome::passed) << m.judged().reason;
  EXPECT_EQ(m.judged().reason.find("class"), std::string::npos) << m.judged().reason;
  m.verdict.axes[1].active->vibration_class = "VC-C";
  EXPECT_EQ(m.judged().outcome, Outcome::passed);
  EXPECT_NE(m.judged().reason.find(
                "By vibration class the frame is worse than its floor in z (VC-C for the floor's "
                "VC-D)."),
            std::string::npos)
      << m.judged().reason;
  m.active().n_saturated = 30000;
  EXPECT_EQ(m.judged().outcome, Outcome::failed);
  EXPECT_EQ(m.judged().reason.find("class"), std::string::npos) << m.judged().reason;
}

TEST(Acceptance, WhatIsNoProofCanOnlyFail) {
  MadeUp m;
  m.verdict.axes.clear();
  Check check;
  check.subject = Subject::prediction;
  check.outcome = Outcome::passed;
  check.is_proof = false;
  m.prediction = {check};
  EXPECT_EQ(m.judged().outcome, Outcome::not_judged);
  EXPECT_EQ(m.judged().reason.find("No direction is compared"), 0u) << m.judged().reason;
  m.prediction[0].is_proof = true;
  EXPECT_EQ(m.judged().outcome, Outcome::passed) << m.judged().reason;
  m.prediction[0].is_proof = false;
  m.prediction[0].outcome = Outcome::failed;
  EXPECT_EQ(m.judged().outcome, Outcome::failed);
}

TEST(Acceptance, AClassThatBandsBeyondHalfTheRateDecideIsNotJudged) {
  const auto outcome = [](const char* asked) {
    MadeUp m({.axes = {{.axis = "z", .vibration_class = asked}}});
    AxisLevels& z = m.verdict.axes[1];
    z.active->vibration_class = "not known";
    z.active_spectra = flat(10e-6);
    z.active_spectra->velocity.back() = nan;
    return m.judged();
  };
  EXPECT_EQ(outcome("VC-A").outcome, Outcome::not_judged);
  EXPECT_NE(outcome("VC-A").reason.find("half the sample rate"), std::string::npos);
  EXPECT_EQ(outcome("VC-E").outcome, Outcome::failed);
  EXPECT_NE(outcome("VC-E").reason.find("is above VC-E"), std::string::npos);
}

TEST(Acceptance, WhatTheSceneNamesTakesThePlaceOfTheDefault) {
  const auto outcome = [](AxisAcceptance asked) {
    asked.axis = "z";
    return MadeUp({.axes = {asked}}).judged();
  };
  EXPECT_EQ(outcome({.vibration_class = "VC-F"}).outcome, Outcome::passed);
  EXPECT_EQ(outcome({.vibration_class = "VC-G"}).outcome, Outcome::failed);
  EXPECT_EQ(outcome({.rms_of_floor = 0.1}).outcome, Outcome::passed);
  EXPECT_EQ(outcome({.rms_of_floor = 0.0999}).outcome, Outcome::failed);
  EXPECT_EQ(outcome({.rms_of_passive = 0.0099}).outcome, Outcome::failed);
  EXPECT_EQ(outcome({.band_of_floor = 0.1}).outcome, Outcome::passed);
  EXPECT_EQ(outcome({.band_of_floor = 0.0999}).outcome, Outcome::failed);
  EXPECT_EQ(outcome({.band_of_passive = 0.0099}).outcome, Outcome::failed);
  // What is asked for and cannot be looked at is not passed, whatever else is well.
  EXPECT_EQ(outcome({.from_hz = 0.1, .rms_of_floor = 1}).outcome, Outcome::not_judged);
  MadeUp other({.axes = {{.axis = "y", .rms_of_floor = 1}}});
  EXPECT_EQ(other.judged().outcome, Outcome::not_judged);
  // The worst band counts, and only bands in the range in which the floor moves.
  MadeUp bands({.axes = {{.axis = "z", .from_hz = 10, .to_hz = 20, .band_of_floor = 0.5}}});
  bands.verdict.axes[1].active_spectra->velocity[0] = 7;  // 1 Hz
  EXPECT_EQ(bands.judged().outcome, Outcome::passed);
  bands.verdict.axes[1].active_spectra->velocity[12] = 7;  // 16 Hz
  EXPECT_EQ(bands.judged().outcome, Outcome::failed);
  bands.verdict.axes[1].floor_spectra->velocity[12] = 1e-9;
  EXPECT_EQ(bands.judged().outcome, Outcome::passed);
  bands.verdict.axes[1].active_spectra->velocity[11] = nan;
  EXPECT_EQ(bands.judged().outcome, Outcome::failed);

  MadeUp shares({.limited_share = 0.5, .lost_share = 0.1, .discarded_share = 0.3});
  shares.active().n_saturated = 30000;
  shares.active().n_lost = 6000;
  shares.active().n_discarded = 16200;
  shares.active().n_commands -= 6000;
  shares.active().n_repeats = 6000;
  EXPECT_EQ(shares.judged().outcome, Outcome::passed) << shares.judged().reason;
}

/// A made-up run in which anything may be wrong.
MadeUp random_run(std::mt19937& random) {
  const auto chance = [&](double p) { return std::bernoulli_distribution(p)(random); };
  const auto value = [&]() -> std::optional<double> {
    if (chance(0.1)) return std::nullopt;
    if (chance(0.1)) return nan;
    return std::exp(std::normal_distribution<double>(0, 2)(random));
  };
  SceneAcceptance accept;
  if (chance(0.3)) {
    accept.axes.push_back({.axis = chance(0.8) ? "z" : "y",
                           .rms_of_floor = value(),
                           .band_of_passive = value(),
                           .vibration_class = "VC-E"});
  }
  MadeUp run(accept);
  if (chance(0.2)) run.verdict.runs.erase(run.verdict.runs.begin() + (chance(0.5) ? 1 : 0));
  for (RunSummary& r : run.verdict.runs) {
    if (chance(0.1)) r.n_damaged = 3;
    if (chance(0.1)) r.n_judged = 4000;
    if (chance(0.1)) r.n_saturated = 3000;
    if (chance(0.1)) r.n_discarded = 3000;
    if (chance(0.1)) r.unreadable = "gains_text: no \"YAML\" <b>";
  }
  for (AxisLevels& axis : run.verdict.axes) {
    if (chance(0.1)) axis.active.reset();
    for (AskedMotion& motion : axis.asked) {
      if (chance(0.6)) continue;
      motion.floor = value();
      motion.passive = value();
      motion.active = value();
    }
  }
  return run;
}

TEST(Acceptance, NothingThatIsNoNumberPassesAndNothingFailedIsLost) {
  std::mt19937 random(20261122);
  std::set<Outcome> seen;
  for (int n = 0; n < 300; ++n) {
    MadeUp run = random_run(random);
    const Judgement judgement = run.judged();
    seen.insert(judgement.outcome);
    EXPECT_EQ(judgement.reason.back(), judgement.reason.ends_with(')') ? ')' : '.');
    bool failed = false;
    for (const Check& check : judgement.checks) {
      EXPECT_FALSE(check.reason.empty()) << check.what;
      failed = failed || check.outcome == Outcome::failed;
      const bool no_number = check.found.find("nan") != std::string::npos;
      EXPECT_FALSE(no_number && check.outcome == Outcome::passed) << check.what;
    }
    EXPECT_EQ(judgement.outcome == Outcome::failed, failed);
    // Text and JSON say what the judgement says.
    run.verdict.judgement = judgement;
    const std::string word(to_text(judgement.outcome));
    const std::string last = "Verdict: " + word + ". " + judgement.reason + "\n";
    EXPECT_TRUE(to_text(run.verdict).ends_with(last)) << to_text(run.verdict);
    const auto json = nlohmann::json::parse(to_json(run.verdict));
    EXPECT_EQ(json.at("outcome"), word);
    EXPECT_EQ(json.at("reason"), judgement.reason);
    EXPECT_EQ(json.at("checks").size(), judgement.checks.size());
    // Whatever else is well or not: one failed check fails the run.
    run.prediction = {{.subject = Subject::prediction,
                       .what = {},
                       .asked = {},
                       .found = {},
                       .outcome = Outcome::failed,
                       .reason = "No."}};
    EXPECT_EQ(run.judged().outcome, Outcome::failed);
  }
  EXPECT_EQ(seen.size(), 3u);
}

}  // namespace
}  // namespace stillframe::report
