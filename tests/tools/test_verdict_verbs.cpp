#include <algorithm>
#include <cmath>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <random>
#include <regex>

#include "judge/page_tables_of.hpp"
#include "judge/prediction_checks.hpp"
#include "msgs/channels.hpp"
#include "report/page/sections.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "tests/tools/damaged_log.hpp"
#include "tests/tools/recorded.hpp"
#include "tests/tools/three_feet.hpp"
#include "tests/tools/verb.hpp"
#include "tools/exit_code.hpp"

namespace stillframe::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The word on the badge of a page.
std::string badge_of(const std::string& html) {
  std::smatch found;
  std::regex_search(html, found, std::regex("<span class=\"badge [a-z]*\">([^<]*)</span>"));
  std::string word = found[1];
  if (!word.empty()) word.front() = static_cast<char>(std::tolower(word.front()));
  return word;
}

/// Runs in one process, and what `run`, `report` and `batch` say of them.
class VerdictVerbs : public Verb {
 protected:
  fs::path frame() const { return config("scenes/metrology_frame.yaml"); }

  Said simulate(const fs::path& out, std::vector<std::string> more) const {
    std::vector<std::string> arguments{"run", frame(), "--mode", "single_process", "--out", out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  /// The frame's controller block with legs that can hardly push.
  fs::path weak_legs() const {
    return write("controller.yaml",
                 std::regex_replace(text_of(config("controllers/force_feedback_5hz.yaml")),
                                    std::regex("force_limit_n: *[0-9.]+"), "force_limit_n: 0.5"));
  }

  /// A run directory, read by everything that can read it: all say the same.
  void expect_everywhere(const fs::path& folder, const Said& said, const std::string& outcome) {
    const int code = outcome == "failed" ? 4 : 0;
    EXPECT_EQ(said.exit_code, code) << said.output << said.error;
    const Json of_run = Json::parse(text_of(folder / "verdict.json"));
    EXPECT_EQ(of_run.at("outcome"), outcome) << of_run.at("reason");
    const std::string last =
        "Verdict: " + outcome + ". " + of_run.at("reason").get<std::string>() + "\n";
    EXPECT_TRUE(text_of(folder / "verdict.txt").ends_with(last));
    EXPECT_EQ(badge_of(text_of(folder / "report.html")), outcome);
    const Said report = run({"report", folder, "--json"});
    EXPECT_EQ(report.exit_code, code);
    EXPECT_EQ(Json::parse(report.output), of_run);
  }
};

TEST_F(VerdictVerbs, AFrameThatItsLimitedForcesShakeFails) {
  const auto limited = weak_legs();
  const Said said = simulate(folder_ / "run", {"--controller", limited, "--duration", "12"});
  expect_everywhere(folder_ / "run", said, "failed");
  const Json verdict = Json::parse(text_of(folder_ / "run/verdict.json"));
  EXPECT_NE(verdict.at("reason").get<std::string>().find("Commands with a limited force: 11"),
            std::string::npos)
      << verdict.at("reason");
  bool shakes = false;
  for (const Json& check : verdict.at("checks")) {
    shakes = shakes || (check.at("subject") == "motion" && check.at("outcome") == "failed");
  }
  EXPECT_TRUE(shakes);
  const Said batch = run({"batch", frame(), "--controller", limited, "--duration", "12", "--json"});
  EXPECT_EQ(batch.exit_code, 4);
  EXPECT_EQ(Json::parse(batch.output)[0].at("outcome"), "failed");
  // A batch identifies nothing, so that fewer checks can fail besides.
  const auto first_reason = [](const Json& of) {
    const auto text = of.at("reason").get<std::string>();
    return text.substr(0, text.rfind(" ("));
  };
  const Json of_batch = Json::parse(batch.output)[0];
  EXPECT_EQ(first_reason(of_batch), first_reason(verdict));
  EXPECT_NE(batch.error.find(of_batch.at("reason").get<std::string>()), std::string::npos);
}

TEST_F(VerdictVerbs, TheFrameAsItIsPasses) {
  draw_pictures();
  const Said said = simulate(folder_ / "run", {"--duration", "12"});
  expect_everywhere(folder_ / "run", said, "passed");
  EXPECT_EQ(said.error.find("plots"), std::string::npos) << said.error;
  for (const char* picture : {"accelerations.png", "third_octaves.png", "singular_values.png"}) {
    EXPECT_GT(fs::file_size(folder_ / "run" / picture), 10000u) << picture;
  }
  const Json verdict = Json::parse(text_of(folder_ / "run/verdict.json"));
  EXPECT_EQ(verdict.at("runs").size(), 2u);
  for (const Json& run : verdict.at("runs")) {
    EXPECT_EQ(run.at("mode"), "single_process");
  }
  EXPECT_NE(text_of(folder_ / "run/report.html").find("single process"), std::string::npos);
  EXPECT_EQ(run({"replay", folder_ / "run/active.lcm"}).exit_code, 0);
}

/// A mass on one leg on a table, with a monitor of the table; a controller block without its head,
/// and what else stands in the scene.
std::string mass_on_a_table(const std::string& controller, const std::string& more) {
  return R"(title: A mass on a shaking table
nodes:
  table: {position: [0, 0, 0]}
  mass: {position: [0, 0, 0.1]}
masses:
  - {node: mass, mass: 10}
elements:
  leg: {type: truss, nodes: [table, mass], stiffness: 4e5, damping: 20}
supports:
  - {nodes: [table, mass], fix: [x, y]}
prescribed:
  - {nodes: [table], move: [z]}
dofs:
  - {element: leg}
inputs:
  - {name: table, acceleration: table, along: z}
outputs:
  - {name: mass, acceleration: mass, along: z}
monitors:
  - {name: tab, acceleration: table, along: z}
compare:
  z: {floor: tab, frame: mass}
controller: {legs: [leg], damping_ratio: 0.7, delay_samples: 1, lead_samples: 1.5, leak_hz: 0.05, )" +
         controller + "}\n" + more;
}

// A prediction that is met says nothing of isolation. The rate is so low that the loop is predicted
// to make more of 45 and 60 Hz than no loop does, and at 30 Hz less; beside half the rate there is
// no line at all at which it is to reduce.
TEST_F(VerdictVerbs, AMultisineOfWhichControlMakesMoreFails) {
  const std::pair<const char*, const char*> worse[] = {
      {"target_hz: 1, sample_rate_hz: 165",
       "floor: {multisine: {frequencies_hz: [20, 30, 45, 60], amplitude: 0.01}}\n"},
      {"target_hz: 5, sample_rate_hz: 1000",
       "floor: {multisine: {frequencies_hz: [496.5, 497.5, 498, 498.5, 499, 499.5], amplitude: "
       "0.01}}\ninstruments: {actuator_gain: 0.7446}\n"}};
  for (const auto& [controller, floor] : worse) {
    const auto scene = write("scene.yaml", mass_on_a_table(controller, floor));
    const auto out = folder_ / ("run" + std::to_string(std::string(floor).size()));
    const Said said = run({"run", scene, "--mode", "single_process", "--out", out});
    expect_everywhere(out, said, "failed");
    const Json checks = Json::parse(text_of(out / "verdict.json")).at("checks");
    EXPECT_TRUE(std::any_of(checks.begin(), checks.end(), [](const Json& check) {
      return check.at("outcome") == "failed" && check.at("what").get<std::string>().find(
                                                    "lines of the multisine") != std::string::npos;
    })) << said.output;
  }
}

// The sensor shakes the frame between the lines, and so much on them that no value of the active
// loop is known. Where the scene compares nothing its outputs are looked at.
TEST_F(VerdictVerbs, WhatMovesBesideTheLinesOfAMultisineFails) {
  const std::string floor =
      "floor: {multisine: {frequencies_hz: [1, 2, 5, 10, 20, 50, 100], amplitude: 0.01, ramp_s: 4, "
      "window_s: 8}}\n";
  const auto outcomes = [&](const std::string& text, const std::string& name) {
    const Said said = run(
        {"run", write(name + ".yaml", text), "--mode", "single_process", "--out", folder_ / name});
    expect_everywhere(folder_ / name, said, name.starts_with("quiet") ? "passed" : "failed");
    std::map<std::string, std::string> found;
    const Json verdict = Json::parse(text_of(folder_ / name / "verdict.json"));
    for (const Json& check : verdict.at("checks")) {
      found[check.at("what")] = check.at("outcome");
    }
    return found;
  };
  // 1 N/sqrt(Hz) of 10 kg is 0.1 m/s^2/sqrt(Hz) at the frame where the loop follows its sensor.
  const auto scene = [&](const char* noise) {
    return mass_on_a_table(
        "target_hz: 5, sample_rate_hz: 1000",
        floor + "instruments: {force_sensors: {noise_n_per_sqrt_hz: " + noise + "}}\n");
  };
  auto found = outcomes(scene("1"), "noisy");
  EXPECT_EQ(found.at("axis z, active to passive frame, rms from 1 to 200 Hz"), "failed");
  EXPECT_EQ(found.at("axis z, active to floor, rms from 10 to 200 Hz"), "failed");
  EXPECT_EQ(found.at("singular values of both loops against the prediction"), "not judged");
  const std::string compare = std::regex_replace(scene("1"), std::regex("compare:\\n.*\\n"), "");
  ASSERT_EQ(compare.find("compare"), std::string::npos);
  found = outcomes(compare, "outputs");
  EXPECT_EQ(found.at("axis mass, active to passive frame, rms from 1 to 200 Hz"), "failed");
  found = outcomes(scene("1e-6"), "quiet");
  EXPECT_EQ(found.at("axis z, active to passive frame, rms from 1 to 200 Hz"), "passed");
  EXPECT_EQ(found.at("axis z, active to floor, rms from 10 to 200 Hz"), "passed");
  EXPECT_EQ(found.at("singular values of both loops against the prediction"), "passed");
  // A force that does nothing excuses nothing here either.
  const auto with = [&](const char* noise, const std::string& force) {
    return scene(noise) + "disturbances: [{name: d, node: mass, along: z, force: {" + force +
           "}}]\n";
  };
  found = outcomes(with("1", "step: {height: 1e-9, at_s: 1}"), "forced");
  EXPECT_EQ(found.at("axis z, active to floor, rms from 10 to 200 Hz"), "failed");
  // An output that nothing can move is no 0 / 0.
  outcomes(std::regex_replace(scene("1e-6"), std::regex("outputs:\n"),
                              "outputs:\n  - {name: aside, acceleration: mass, along: x}\n"),
           "quiet_aside");
}

// A floor that moves above the range in which levels are compared leaves nothing but the ends of
// its record there.
TEST_F(VerdictVerbs, WhatARecordsEndsLeaveIsNoIsolation) {
  const auto scene = write("scene.yaml", mass_on_a_table("target_hz: 5, sample_rate_hz: 1000",
                                                         "floor: {noise: {psd: [[250, 1e-8], [400, "
                                                         "1e-8]], duration_s: 20}}\n"));
  const Said said = run({"run", scene, "--mode", "single_process", "--out", folder_ / "run"});
  expect_everywhere(folder_ / "run", said, "not judged");
  EXPECT_NE(said.output.find("neither frame moves from 1 to 200 Hz"), std::string::npos)
      << said.output;
}

/// The one check whose subject's text has this in it.
Json check_with(const Json& verdict, const std::string& text) {
  Json found;
  for (const Json& check : verdict.at("checks")) {
    if (check.at("what").get<std::string>().find(text) == std::string::npos) continue;
    EXPECT_TRUE(found.is_null()) << "twice: " << text;
    found = check;
  }
  return found;
}

Json check_with(const fs::path& verdict, const std::string& text) {
  return check_with(Json::parse(text_of(verdict)), text);
}

// A floor that is lively below the range, at 0.08 to 0.12 Hz, under a frame that isolates above
// 0.2 Hz. A transform of the exported log (numpy) has 0.0483 of the floor there; windows of 16 s
// make it more than 1.
TEST_F(VerdictVerbs, ALevelIsOfItsRangeHoweverLowThatIs) {
  std::string text = mass_on_a_table(
      "target_hz: 0.1, sample_rate_hz: 100",
      "floor: {noise: {psd: [[0.02, 1e-15], [0.075, 1e-15], [0.08, 1e-9], [0.12, 1e-9], [0.13, "
      "1e-15], [0.3, 3e-15], [40, 3e-15]], duration_s: 600, axes: [z], high_pass_hz: 0.01}}\n");
  text.replace(text.find("4e5"), 3, "3553");
  text.replace(text.find("damping: 20"), 11, "damping: 5");
  text.replace(text.find("damping_ratio: 0.7"), 18, "damping_ratio: 0.2");
  text.replace(text.find("leak_hz: 0.05"), 13, "leak_hz: 0.0003");
  const auto out = folder_ / "run";
  run({"run", write("scene.yaml", text), "--mode", "single_process", "--out", out});
  const Json check = check_with(out / "verdict.json", "active to floor, rms from 0.2");
  EXPECT_EQ(check.at("outcome"), "passed") << check;
  EXPECT_NEAR(std::stod(check.at("found").get<std::string>()), 0.0483, 0.0005);
}

// What only the loop shakes.
TEST_F(VerdictVerbs, AFrameThatRestsWithoutItsLoopHasToRestWithIt) {
  const auto judged = [&](const std::string& more) {
    const auto out = folder_ / std::to_string(more.size());
    const auto scene =
        write("scene.yaml", mass_on_a_table("target_hz: 5, sample_rate_hz: 1000",
                                            "floor: {still: {duration_s: 12}}\n" + more));
    const Said said = run({"run", scene, "--mode", "single_process", "--out", out});
    return std::pair(said.exit_code, Json::parse(text_of(out / "verdict.json")));
  };
  const auto [code, verdict] =
      judged("instruments: {force_sensors: {noise_n_per_sqrt_hz: 0.01}}\n");
  EXPECT_EQ(code, 4);
  EXPECT_NE(verdict.at("reason").get<std::string>().find("which only its own loop can do"),
            std::string::npos)
      << verdict.at("reason");
  EXPECT_EQ(judged("").second.at("outcome"), "not judged");
  EXPECT_EQ(judged("disturbances: [{name: d, node: mass, along: z, force: {noise: {psd: [[1, "
                   "1e-2], [400, 1e-2]]}}}]\n")
                .second.at("outcome"),
            "passed");
}

/// A table on two legs and a third beside it, which all turn a little as it moves along x.
std::string table_on_three_feet(const std::string& floor) {
  return three_feet("0") + R"(gravity: [0, -9.81]
inputs: [{name: fs_x, acceleration: fs, along: x}]
monitors: [{name: g_x, acceleration: fs, along: x}, {name: g_y, acceleration: fl, along: y}]
controller: {legs: [left, right, side], target_hz: 3, damping_ratio: 0.7, sample_rate_hz: 1000,
  delay_samples: 1, leak_hz: 0.6}
floor: )" +
         floor + "\n";
}

// A perfect run failed by 1.2 times 5e-8 m/s^2 along y, where only the second order of 3e-4 m/s^2
// along x moves the frame.
TEST_F(VerdictVerbs, WhatMovesByTheSecondOrderOnlyFailsNoRun) {
  for (const char* floor :
       {"{step: {height: 0.0001, rise_s: 0.5, at_s: 2, axis: x, duration_s: 12}}",
        "{multisine: {frequencies_hz: [1, 2, 3, 5, 8], amplitude: 0.004}}"}) {
    const auto out = folder_ / std::string(floor, 1, 4);
    const auto scene = write("scene.yaml", table_on_three_feet(floor));
    expect_everywhere(out, run({"run", scene, "--mode", "single_process", "--out", out}), "passed");
    const Json check = check_with(out / "verdict.json", "axis y, active to passive");
    EXPECT_NE(check.at("reason").get<std::string>().find("of what the largest axis does"),
              std::string::npos)
        << check;
  }
}

/// Two struts under preload, stiff across themselves, and one that carries; each foot measured
/// along its strut alone.
std::string preloaded_frame(const std::string& axes, const std::string& seconds = "20") {
  return R"(title: preloaded
planar: true
nodes: {l: {position: [-0.1, 0]}, r: {position: [0.1, 0]}, b: {position: [0, -0.1]}, m: {position: [0, 0]}}
masses: [{node: m, mass: 10}]
elements:
  ll: {type: truss, nodes: [l, m], stiffness: 2e5, damping: 20, preload: 3000}
  lr: {type: truss, nodes: [m, r], stiffness: 2e5, damping: 20, preload: 3000}
  lb: {type: truss, nodes: [b, m], stiffness: 2e5, damping: 20}
prescribed: [{nodes: [l, r, b], move: [x, y]}]
dofs: [{node: m, along: x}, {node: m, along: y}]
inputs:
  - {name: l, acceleration: l, along: x}
  - {name: r, acceleration: r, along: x}
  - {name: b, acceleration: b, along: y}
outputs: [{name: mx, acceleration: m, along: x}, {name: my, acceleration: m, along: y}]
monitors: [{name: fx, acceleration: b, along: x}, {name: fy, acceleration: b, along: y}]
compare: {x: {floor: fx, frame: mx}, y: {floor: fy, frame: my}}
controller: {legs: [ll, lb], target_hz: 5, damping_ratio: 0.7, sample_rate_hz: 1000, delay_samples: 1,
  lead_samples: 1.25, leak_hz: 3, force_limit_n: 200, roll_off_hz: 200}
floor: {noise: {psd: [[1, 1e-8], [100, 1e-8]], duration_s: )" +
         seconds + ", axes: " + axes + "}}\n";
}

// Struts under preload are stiff across themselves, where no input measures the floor: the axes
// know that it does not turn, and the loop is the predicted one. It used to fail by 5.7 dB, and
// any trace of gravity hid that.
TEST_F(VerdictVerbs, APreloadedFrameMeetsItsPrediction) {
  for (const char* gravity : {"0", "-1e-6"}) {
    const auto scene =
        write("scene.yaml", preloaded_frame("[x, y]", "60") + "gravity: [0, " + gravity + "]\n");
    const auto out = folder_ / gravity;
    record(scene, out);
    const Json verdict = judged(out);
    const Json check = check_with(verdict, "active, 2 floors to 2 frames");
    ASSERT_FALSE(check.is_null());
    EXPECT_EQ(check.at("outcome"), "passed") << check;
    for (const Json& warning : verdict.at("warnings")) {
      EXPECT_EQ(warning.get<std::string>().find("is not what the model says"), std::string::npos)
          << warning;
    }
  }
}

// One floor under one frame is one response, however it is named.
TEST_F(VerdictVerbs, NothingIsAskedTwice) {
  const auto scene = write("scene.yaml", mass_on_a_table("target_hz: 5, sample_rate_hz: 1000",
                                                         "floor: {white: {rms: 1e-3, "
                                                         "duration_s: 20}}\n"));
  const auto out = folder_ / "run";
  expect_everywhere(out, run({"run", scene, "--mode", "single_process", "--out", out}), "passed");
  const Json check = check_with(out / "verdict.json", "active, 1 ");
  EXPECT_NE(check.at("reason").get<std::string>().find("is broadly the predicted one"),
            std::string::npos)
      << check;
  const Json verdict = Json::parse(text_of(out / "verdict.json"));
  for (const Json& one : verdict.at("checks")) {
    const auto reason = one.at("reason").get<std::string>();
    EXPECT_EQ(reason.find("is not the predicted one"), std::string::npos) << reason;
  }
}

// A force in a year's time is no excuse for a frame that shakes more than its floor.
TEST_F(VerdictVerbs, AForceThatNeverActsExcusesNothing) {
  const std::string floor = "floor: {noise: {vc: D, duration_s: 20}}\n";
  const std::string force =
      "disturbances: [{name: d, node: mass, along: z, force: {impact: {peak: 1, width_s: 0.1, "
      "at_s: 1e6}}}]\n";
  for (const std::string& more : {floor, floor + force}) {
    const auto scene =
        write("scene.yaml", mass_on_a_table("target_hz: 1, sample_rate_hz: 165", more));
    const auto out = folder_ / ("run" + std::to_string(more.size()));
    expect_everywhere(out, run({"run", scene, "--mode", "single_process", "--out", out}), "failed");
  }
}

// A converter of 1 N a step shakes the frame 3.2 times as much as its floor. A force that cannot
// have done that is no excuse, whether it is nothing or next to nothing; one that can have is.
TEST_F(VerdictVerbs, AForceExcusesNoMoreThanItDoes) {
  const std::string shaken =
      "instruments: {force_sensors: {quantisation_n: 1}}\n"
      "floor: {noise: {psd: [[0.5, 1e-6], [100, 1e-6]], duration_s: 15, high_pass_hz: 0.2}}\n";
  const auto force = [](const std::string& course) {
    return "disturbances: [{name: d, node: mass, along: z, force: {" + course + "}}]\n";
  };
  const std::pair<std::string, const char*> cases[] = {
      {"", "failed"},
      {force("step: {height: 0, at_s: 1}"), "failed"},
      {force("step: {height: 1e-9, at_s: 1}"), "failed"},
      {force("sine: {amplitude: 1e-9, frequency_hz: 20}"), "failed"},
      {force("noise: {psd: [[1, 1e-1], [200, 1e-1]]}"), "not judged"}};
  for (const auto& [more, outcome] : cases) {
    const auto scene =
        write("scene.yaml", mass_on_a_table("target_hz: 5, sample_rate_hz: 1000", shaken + more));
    const auto out = folder_ / ("run" + std::to_string(more.size()));
    const Said said = run({"run", scene, "--mode", "single_process", "--out", out});
    const Json check = check_with(out / "verdict.json", "active to floor");
    EXPECT_EQ(check.at("outcome"), outcome) << more << check;
    if (outcome == std::string("failed")) expect_everywhere(out, said, "failed");
    const Json batch = Json::parse(run({"batch", scene, "--json"}).output)[0];
    EXPECT_EQ(batch.at("outcome") == "failed", outcome == std::string("failed")) << more << batch;
  }
}

// The model of a force is right to some 1e-4 of it, which at a line may be as much as the line: the
// 41 % by which it is doubted are 170 times what the frame makes of this one.
TEST_F(VerdictVerbs, AForceAtALineOfAMultisineIsNotTakenForTheFloorsDoing) {
  for (const auto& [frequency, n_known] : {std::pair("20", 6), std::pair("22", 7)}) {
    const auto scene =
        write("scene.yaml",
              mass_on_a_table("target_hz: 5, sample_rate_hz: 1000",
                              "floor: {multisine: {frequencies_hz: [1, 2, 5, 10, 20, 50, 100], "
                              "amplitude: 0.01, ramp_s: 4, window_s: 8}}\n"
                              "disturbances: [{name: d, node: mass, along: z, force: {sine: "
                              "{amplitude: 1, frequency_hz: " +
                                  std::string(frequency) + "}}}]\n"));
    const auto out = folder_ / frequency;
    run({"run", scene, "--mode", "single_process", "--out", out});
    const Json found = Json::parse(text_of(out / "verdict.json")).at("identification");
    EXPECT_TRUE(found.at("pass").get<bool>()) << found;
    EXPECT_EQ(found.at("n_closed_compared"), n_known) << frequency << found;
  }
}

// What the model makes of a force is what the force does, sample by sample: one sample off it would
// be as much again at 100 Hz.
TEST_F(VerdictVerbs, TheModelKnowsWhatAForceDoes) {
  const auto scene = write(
      "scene.yaml",
      mass_on_a_table("target_hz: 5, sample_rate_hz: 1000",
                      "floor: {noise: {psd: [[1, 1e-16], [100, 1e-16]], duration_s: 20}}\n"
                      "disturbances: [{name: d, node: mass, along: z, force: {noise: {psd: [[1, "
                      "1e-2], [300, 1e-2]]}}}]\n"));
  const auto out = folder_ / "run";
  run({"run", scene, "--mode", "single_process", "--out", out});
  const Json verdict = Json::parse(text_of(out / "verdict.json"));
  EXPECT_EQ(verdict.at("disturbed"), true);
  for (const Json& range : verdict.at("axes")[0].at("ranges")) {
    const double whole = range.at("active_rms_m_s2");
    // A simulation errs by 3e-4 of its motion at most, 30 times its tolerance.
    EXPECT_NEAR(range.at("active_by_forces_m_s2").get<double>(), whole, 3e-4 * whole);
    EXPECT_LE(range.at("active_undisturbed_m_s2").get<double>(), 3e-4 * whole);
  }
}

// What comes of feet that no input measures is no noise where the inputs tell how they move, and
// not known where they do not.
TEST_F(VerdictVerbs, TheFloorIsNoNoise) {
  const auto noise_of = [&](const std::string& axes) {
    const auto out = folder_ / std::to_string(axes.size());
    run({"run", write("scene.yaml", preloaded_frame(axes)), "--mode", "single_process", "--out",
         out});
    return Json::parse(text_of(out / "verdict.json")).at("noise");
  };
  for (const Json& noise : noise_of("[x, y]")) {
    ASSERT_FALSE(noise.at("share").is_null()) << noise;
    // 3e-4 of tolerance, of a frame whose floor it isolates from: ten times that.
    EXPECT_LT(noise.at("share").get<double>(), 3e-3) << noise;
  }
  for (const Json& noise : noise_of("[x, y, rz]")) {
    if (noise.at("axis") != "y") continue;  // no foot that nothing measures moves the frame along x
    EXPECT_TRUE(noise.at("share").is_null()) << noise;
    EXPECT_NE(noise.at("missing").get<std::string>().find("the floor turns, or its feet move each "
                                                          "on their own"),
              std::string::npos)
        << noise;
  }
}

// A direction in which symmetry lets nothing move is no dead sensor: x here, on a floor along y.
TEST_F(VerdictVerbs, WhatNothingMovesMayRest) {
  const auto out = folder_ / "run";
  // With a leg along y alone: one along x would feel the second order of what moves along y.
  std::string scene = preloaded_frame("[y]");
  scene.replace(scene.find("[ll, lb]"), 8, "[lb]");
  run({"run", write("scene.yaml", scene), "--mode", "single_process", "--out", out});
  const Json verdict = Json::parse(text_of(out / "verdict.json"));
  ASSERT_EQ(verdict.at("runs").size(), 2u);
  for (const Json& of : verdict.at("runs")) {
    EXPECT_TRUE(of.at("resting_channels").empty()) << of;
    EXPECT_TRUE(of.at("resting_forces").empty()) << of;
  }
}

// A multisine moves each input on its own: the monitors of a floor that would follow them rest.
TEST_F(VerdictVerbs, AMultisineLeavesMonitorsAtRest) {
  const auto out = folder_ / "run";
  // Lines of 4 / window_s, away from 13.9, 20.0, 31.3 and 49.0 Hz.
  const auto floor = write("floor.yaml",
                           "multisine: {frequencies_hz: [2, 4, 6, 10, 16, 24, 36, 56, 80, 128, "
                           "200], amplitude: 0.001, ramp_s: 2, window_s: 2}\n");
  const Said said =
      run({"run", frame(), "--floor", floor, "--mode", "single_process", "--out", out});
  expect_everywhere(out, said, "passed");
  const Json verdict = Json::parse(text_of(out / "verdict.json"));
  for (const Json& of : verdict.at("runs")) EXPECT_TRUE(of.at("resting_channels").empty()) << of;
}

// A blow is as smooth as a floor below its corner: it was taken for the floor's doing there, and a
// sound loop failed by 118 dB.
TEST_F(VerdictVerbs, ABlowIsNotTakenForTheFloorsDoing) {
  const std::string bench = three_feet("0.05") + R"(inputs:
  - {name: fl_y, acceleration: fl, along: y}
  - {name: fr_y, acceleration: fr, along: y}
  - {name: fs_x, acceleration: fs, along: x}
monitors: [{name: g_x, acceleration: fs, along: x}, {name: g_y, acceleration: fl, along: y}]
controller: {legs: [left, right, side], target_hz: 3, damping_ratio: 0.7, sample_rate_hz: 1000, delay_samples: 1,
  lead_samples: 1.5, leak_hz: 0.6}
floor: {noise: {vc: C, axes: [x, y], duration_s: 60, seed: 5, high_pass_hz: 0.5}}
)";
  for (const char* blow : {"step: {height: 20, rise_s: 0.1, at_s: 5}",
                           "impact: {peak: 500, width_s: 0.01, at_s: 5}"}) {
    const auto scene = write("scene.yaml", bench +
                                               "disturbances: [{name: stage, node: c, along: x, "
                                               "force: {" +
                                               blow + "}}]\n");
    const auto out = folder_ / std::to_string(std::string(blow).size());
    record(scene, out);
    const Json verdict = judged(out);
    EXPECT_NE(verdict.at("outcome"), "failed") << verdict.at("reason");
    int n = 0;
    for (const Json& response : verdict.at("responses")) {
      // The floor shows what it moves, and nothing else is believed. It does not turn, so three
      // inputs are not told apart.
      if (response.at("what") == "2 floors to 2 frames") n += response.at("n_compared").get<int>();
      EXPECT_LT(response.at("beyond_db").get<double>(), 0.1) << response;
    }
    EXPECT_GE(n, 10) << blow;
  }
  // One whose recording is gone cannot be taken off: the comparison failed by 120 dB. It fails
  // nothing now, but neither does the run pass.
  std::string csv = "# units=N\n# fs_hz=100\n# n=6000\nF\n";
  for (int k = 0; k < 6000; ++k) csv += k < 500 ? "0\n" : "20\n";
  const auto recording = write("blow.csv", csv);
  const auto scene = write("scene.yaml", bench +
                                             "disturbances: [{name: stage, node: c, along: x, "
                                             "force: {recording: {file: " +
                                             recording.string() + ", column: F}}}]\n");
  const auto out = folder_ / "recorded";
  record(scene, out);
  ASSERT_NE(judged(out).at("outcome"), "failed");
  fs::remove(recording);
  const Said said = run({"report", out, "--json"});
  EXPECT_EQ(said.exit_code, 0) << said.output;
  int n_open = 0;
  const Json verdict = Json::parse(said.output);
  for (const Json& check : verdict.at("checks")) {
    if (check.at("subject") != "prediction") continue;
    EXPECT_EQ(check.at("outcome"), "not judged") << check;
    EXPECT_NE(check.at("reason").get<std::string>().find(recording.string()), std::string::npos);
    ++n_open;
  }
  EXPECT_EQ(n_open, 2);  // the axes of both loops
  EXPECT_EQ(verdict.at("outcome"), "not judged");
  // And a dead sensor is found all the same.
  damage_log(
      out / "active.lcm", folder_ / "damaged.lcm",
      [](stillframe_msgs::measurement_t& m) { m.frame_acceleration.at(0) = 0; },
      [](const std::string&, int) { return false; });
  const Json dead = judged(std::vector<fs::path>{out / "passive.lcm", folder_ / "damaged.lcm"});
  EXPECT_EQ(dead.at("runs")[1].at("resting_channels"), Json{"c_x"});
}

// One rule judges a run and a case of a batch, on any floor, whatever a scene asks for.
TEST_F(VerdictVerbs, ABatchJudgesAsARunDoes) {
  const std::string frame = "target_hz: 5, sample_rate_hz: 1000";
  const std::string fast = "floor: {noise: {psd: [[180, 1e-6], [400, 1e-6]], duration_s: 20}}\n",
                    lines =
                        "floor: {multisine: {frequencies_hz: [1, 3, 10, 30, 60, 100], "
                        "amplitude: 0.01}}\n",
                    steps = "instruments: {force_sensors: {quantisation_n: 1}}\n";
  const std::pair<std::string, const char*> cases[] = {
      // Above 80 Hz the loop makes more of its floor.
      {fast, "failed"},
      {lines + "accept: {axes: {z: {rms_of_passive: 0.01}}}\n", "failed"},
      {lines + steps + "accept: {axes: {z: {rms_of_passive: 0.05}}}\n", "failed"},
      {lines + "accept: {axes: {z: {rms_of_passive: 0.9}}}\n", "passed"},
      {lines + "accept: {axes: {z: {class: VC-G}}}\n", "failed"}};
  int n = 0;
  for (const auto& [more, outcome] : cases) {
    const auto scene = write("scene.yaml", mass_on_a_table(frame, more));
    const auto out = folder_ / ("run" + std::to_string(n++));
    const Said said = run({"run", scene, "--mode", "single_process", "--out", out});
    const Json verdict = Json::parse(text_of(out / "verdict.json"));
    const Json batch = Json::parse(run({"batch", scene, "--json"}).output)[0];
    EXPECT_EQ(verdict.at("outcome"), outcome) << more << said.output;
    EXPECT_EQ(batch.at("outcome"), outcome) << more << batch;
  }
}

TEST_F(VerdictVerbs, AFloorIsNoFrame) {
  std::string text = mass_on_a_table("target_hz: 5, sample_rate_hz: 1000",
                                     "floor: {white: {rms: 1e-2, duration_s: 20}}\n");
  const auto place = text.find("frame: mass");
  for (const char* frame : {"frame: tab", "frame: base"}) {
    std::string other = text;
    other.replace(place, 11, frame);
    other.replace(other.find("compare:"), 0, "  - {name: base, acceleration: table, along: z}\n");
    const Said said = run({"modes", write("scene.yaml", other)});
    EXPECT_EQ(said.exit_code, 2);
    EXPECT_NE(said.error.find("frame"), std::string::npos) << said.error;
  }
}

TEST_F(VerdictVerbs, NumbersThatAreNoneAreBadUsage) {
  const auto scene = write("scene.yaml", mass_on_a_table("target_hz: 5, sample_rate_hz: 1000",
                                                         "floor: {noise: {vc: D, duration_s: "
                                                         "12}}\n"));
  ASSERT_EQ(run({"run", scene, "--mode", "single_process", "--out", folder_ / "run"}).exit_code, 0);
  for (const char* number : {"nan", "inf", "1e-9", "0.0004", "0"}) {
    EXPECT_EQ(run({"report", folder_ / "run", "--segment", number}).exit_code, 2) << number;
    EXPECT_EQ(run({"identify", folder_ / "run/active.lcm", "--segment", number}).exit_code, 2);
  }
  EXPECT_EQ(run({"report", folder_ / "run", "--tolerance-db", "nan"}).exit_code, 2);
}

TEST_F(VerdictVerbs, ARunWithNothingToJudgeByIsNotJudged) {
  expect_everywhere(folder_ / "short", simulate(folder_ / "short", {"--duration", "2"}),
                    "not judged");
  expect_everywhere(folder_ / "passive",
                    simulate(folder_ / "passive", {"--duration", "12", "--loop", "passive"}),
                    "not judged");
  const auto still = write("still.yaml", "still: {duration_s: 12}\n");
  expect_everywhere(folder_ / "still", simulate(folder_ / "still", {"--floor", still}),
                    "not judged");
}

TEST_F(VerdictVerbs, WhatTheSceneAcceptsIsInItsLog) {
  std::string scene = text_of(frame());
  for (const char* block : {"controllers", "floors"}) {
    scene = std::regex_replace(scene, std::regex(std::string("\\.\\./") + block),
                               config(block).string());
  }
  const auto run_with = [&](const std::string& name, const std::string& accept) {
    const auto file = write(name + ".yaml", scene + "accept: " + accept + "\n");
    return run(
        {"run", file, "--mode", "single_process", "--duration", "12", "--out", folder_ / name});
  };
  // The README's table: y meets VC-E on this floor, and moves less than half of what the floor
  // does.
  expect_everywhere(folder_ / "strict", run_with("strict", "{axes: {y: {class: VC-G}}}"), "failed");
  expect_everywhere(folder_ / "fair",
                    run_with("fair", "{axes: {y: {band_of_floor: 0.5, from_hz: 10, to_hz: 80}}}"),
                    "passed");
}

TEST_F(VerdictVerbs, LogsOfDifferentFloorsAreSetEachAgainstItsOwn) {
  const auto quake = config("floors/quake.yaml"), multisine = config("floors/multisine.yaml");
  for (const auto& [name, loop, floor] :
       std::initializer_list<std::tuple<const char*, const char*, std::string>>{
           {"own", "both", ""}, {"quake", "passive", quake}, {"lines", "both", multisine}}) {
    RecordOptions options{.duration_s = 12};
    if (loop == std::string("passive")) options.loops = {loop};
    if (!floor.empty()) options.floor = floor;
    record(frame(), folder_ / name, options);
  }
  const auto verdict_of = [&](const fs::path& passive, const fs::path& active) {
    return judged(std::vector<fs::path>{passive, active});
  };
  const Json own = verdict_of(folder_ / "own/passive.lcm", folder_ / "own/active.lcm");
  EXPECT_TRUE(own.at("warnings").empty());
  const Said said = run({"report", folder_ / "quake/passive.lcm", folder_ / "own/active.lcm",
                         "--out", folder_ / "page.html", "--json"});
  EXPECT_TRUE(said.exit_code == 0 || said.exit_code == 4) << said.exit_code << said.error;
  const Json quaked = Json::parse(said.output);
  ASSERT_EQ(quaked.at("warnings").size(), 1u);
  EXPECT_NE(text_of(folder_ / "page.html").find(quaked.at("warnings")[0].get<std::string>()),
            std::string::npos);
  ASSERT_EQ(quaked.at("axes").size(), 6u);
  for (std::size_t a = 0; a < 3; ++a) {
    const Json &passive = quaked.at("axes")[a], &active = quaked.at("axes")[a + 3];
    EXPECT_FALSE(passive.contains("active") || active.contains("passive"));
    EXPECT_FALSE(active.contains("ratio_active_to_passive"));
    EXPECT_NE(passive.at("floor"), active.at("floor"));
    EXPECT_EQ(active.at("floor"), own.at("axes")[a].at("floor"));
    EXPECT_EQ(active.at("active"), own.at("axes")[a].at("active"));
  }
  // A multisine beside a recorded floor, either way round.
  EXPECT_EQ(verdict_of(folder_ / "lines/passive.lcm", folder_ / "own/active.lcm").at("axes").size(),
            3u);
  EXPECT_EQ(verdict_of(folder_ / "own/passive.lcm", folder_ / "lines/active.lcm").at("axes").size(),
            3u);
}

// The text of a recorded floor names a file, and what stands in that may change.
TEST_F(VerdictVerbs, ARecordingOfTheSameNameNeedNotBeTheSameFloor) {
  const auto scene = write("scene.yaml", mass_on_a_table("target_hz: 5, sample_rate_hz: 1000",
                                                         "floor: {recording: {file: rec.csv, "
                                                         "axes: {z: z}}}\n"));
  for (const auto& [name, rms] : {std::pair("weak", 1e-3), {"strong", 1e-1}}) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal(0, rms);
    std::string csv = "# units=m/s^2\n# fs_hz=500\n# n=10000\nz\n";
    for (int k = 0; k < 10000; ++k) csv += std::to_string(normal(random)) + "\n";
    write("rec.csv", csv);
    ASSERT_EQ(run({"run", scene, "--mode", "single_process", "--out", folder_ / name}).exit_code,
              0);
  }
  const auto verdict_of = [&](const char* passive, const char* active) {
    return Json::parse(
        run({"report", folder_ / passive / "passive.lcm", folder_ / active / "active.lcm", "--out",
             folder_ / "page.html", "--json"})
            .output);
  };
  const Json same = verdict_of("weak", "weak"), other = verdict_of("strong", "weak");
  EXPECT_TRUE(same.at("warnings").empty());
  EXPECT_TRUE(same.at("axes")[0].contains("ratio_active_to_passive"));
  ASSERT_EQ(other.at("warnings").size(), 1u);
  EXPECT_NE(other.at("warnings")[0].get<std::string>().find("floors of their own"),
            std::string::npos);
  EXPECT_FALSE(other.at("axes")[0].contains("ratio_active_to_passive"));
}

// A dead sensor on the frame reads what perfect isolation does.
TEST_F(VerdictVerbs, AChannelThatNeverChangesPassesNothing) {
  record(frame(), folder_ / "run", {.duration_s = 12});
  using stillframe_msgs::measurement_t;
  const auto log_of = [&](const std::string& loop) { return folder_ / "run" / (loop + ".lcm"); };
  const auto other_than = [](const std::string& loop) {
    return loop == "active" ? "passive" : "active";
  };
  // The log of the other loop, which is whole, is analysed once for all.
  std::map<std::string, judge::RunAnalysis> whole;
  for (const char* loop : {"passive", "active"}) {
    whole.emplace(loop, judge::analyse_run(log_of(loop)));
  }
  const auto report = [&](const char* loop, auto&& change) {
    damage_log(log_of(loop), folder_ / "damaged.lcm", change,
               [](const std::string&, int) { return false; });
    judge::RunAnalysis& other = whole.at(other_than(loop));
    const bool is_active = other.active();
    judge::RunAnalyses runs;
    runs.add(std::move(other));
    runs.add(judge::analyse_run(folder_ / "damaged.lcm"));
    const Json verdict = judged(runs);
    other = std::move(*(is_active ? runs.active : runs.passive));
    return verdict;
  };
  // What the program says of the log that was damaged last; of every verdict VerdictAgreement has
  // it.
  const auto expect_of_program = [&](const char* loop, const Json& verdict) {
    const Said said = run({"report", log_of(other_than(loop)), folder_ / "damaged.lcm", "--out",
                           folder_ / "page.html", "--json"});
    EXPECT_EQ(Json::parse(said.output), verdict);
    EXPECT_EQ(badge_of(text_of(folder_ / "page.html")), verdict.at("outcome"));
    EXPECT_EQ(said.exit_code, verdict.at("outcome") == "failed" ? 4 : 0);
  };
  const auto expect = [](const Json& verdict, const std::string& outcome, const std::string& part) {
    EXPECT_EQ(verdict.at("outcome"), outcome) << verdict.at("reason");
    EXPECT_NE(verdict.at("reason").get<std::string>().find(part), std::string::npos)
        << verdict.at("reason");
  };
  // Three outputs of three nodes, then the lens among the monitors.
  const auto stuck = [](std::size_t first, std::size_t last, double value) {
    return [=](measurement_t& m) {
      for (std::size_t i = first; i < last; ++i) m.frame_acceleration.at(i) = value;
    };
  };
  for (const char* loop : {"active", "passive"}) {
    const Json of_one = report(loop, stuck(9, 10, 0));
    expect(of_one, "not judged", "lens_x never changes by a bit");
    expect_of_program(loop, of_one);
    expect(report(loop, stuck(9, 12, 0)), "not judged", "lens_x, lens_y, lens_z never change");
  }
  const Said text = run({"report", folder_ / "damaged.lcm"});
  EXPECT_NE(text.output.find("Verdict: not judged. In the log of the passive run lens_x, "),
            std::string::npos)
      << text.output;
  expect(report("active", stuck(9, 10, 0.01)), "not judged", "lens_x never changes");
  expect(report("active", stuck(0, 12, 0)), "not judged", "never change");
  const Json forceless = report("active", [](measurement_t& m) {
    std::fill(m.applied_force.begin(), m.applied_force.end(), 0.0);
  });
  expect(forceless, "failed", "never changes by a bit though the commands do");
  expect_of_program("active", forceless);
  const Json sound = report("active", [](measurement_t&) {});
  expect(sound, "passed", "All ");
  expect_of_program("active", sound);
  // From some sample on, or until then.
  for (const bool dies : {true, false}) {
    const auto dead = [&](auto list, std::size_t i) {
      return [=](measurement_t& m) {
        if ((m.seq >= 3000) == dies) (m.*list).at(i) = 0.25;
      };
    };
    const std::string when = dies ? " (from 3 to 12 s)" : " (from 0 to 2.999 s)";
    for (const char* loop : {"active", "passive"}) {
      expect(report(loop, dead(&measurement_t::frame_acceleration, 9)), "not judged",
             "lens_x" + when + " never changes by a bit");
    }
    expect(report("active", dead(&measurement_t::frame_acceleration, 8)), "not judged",
           "floor_z" + when + " never changes by a bit");
    expect(report("active", dead(&measurement_t::applied_force, 2)), "failed",
           "the applied force of leg_2t" + when + " never changes by a bit though the commands do");
    for (const char* of : {"sigma of leg_2t", "floor input floor_1v"}) {
      const bool is_sigma = of[0] == 's';
      const Json verdict = report("active", is_sigma ? dead(&measurement_t::sigma, 2)
                                                     : dead(&measurement_t::floor_acceleration, 1));
      ASSERT_EQ(verdict.at("runs")[1].at("resting_channels"), Json{of + when}) << verdict;
      EXPECT_NE(verdict.at("outcome"), "passed");
    }
  }
  expect(report("active", [](measurement_t& m) { m.sigma.at(2) = 0; }), "not judged",
         "sigma of leg_2t never changes by a bit");
  expect(report("active", [](measurement_t& m) { m.floor_acceleration.at(1) = 0; }), "not judged",
         "floor input floor_1v never changes by a bit");
  // Of a floor that is a thousandth of itself for half the run, converters of 12 bits show nothing.
  const Json quiet = report("passive", [](measurement_t& m) {
    const double scale = m.seq < 6000 ? 1e-3 : 1;
    for (double& a : m.floor_acceleration) a *= scale;
    // +-0.1 m/s^2, ten times what the frame moves.
    for (double& a : m.frame_acceleration) a = 0.2 / 4096 * std::round(scale * a / (0.2 / 4096));
  });
  EXPECT_TRUE(quiet.at("runs")[0].at("resting_channels").empty()) << quiet;
  // A converter of the frame's sensors that is coarse, but not as coarse as the motion.
  const Json coarse = report("active", [](measurement_t& m) {
    for (double& a : m.frame_acceleration) a = 1e-4 * std::round(a / 1e-4);
  });
  EXPECT_TRUE(coarse.at("runs")[1].at("resting_channels").empty());
}

// What a knock leaves behind lasts longer than the knock, of the floor or of a force.
TEST_F(VerdictVerbs, ASensorThatIsDeadWhenSomethingKnocksPassesNothing) {
  const std::pair<std::string, std::int64_t> knocks[] = {
      {"floor: {impact: {peak: 1, width_s: 0.04, at_s: 2, axis: z, duration_s: 10}}\n", 0},
      {"floor: {step: {height: 1e-4, rise_s: 0.045, at_s: 2, axis: z, duration_s: 10}}\n", 0},
      {"floor: {still: {duration_s: 10}}\ndisturbances:\n"
       "  - {name: a, node: mass, along: z, force: {impact: {peak: 40, width_s: 0.01, at_s: 2}}}\n"
       "  - {name: b, node: mass, along: z, force: {impact: {peak: 40, width_s: 0.01, at_s: 7}}}\n",
       5000}};
  int n = 0;
  for (const auto& [knock, dies] : knocks) {
    const auto scene =
        write("scene.yaml", mass_on_a_table("target_hz: 5, sample_rate_hz: 1000", knock));
    const auto out = folder_ / ("run" + std::to_string(n++));
    run({"run", scene, "--mode", "single_process", "--out", out});
    const Json sound = Json::parse(text_of(out / "verdict.json"));
    for (const Json& of : sound.at("runs")) {
      EXPECT_TRUE(of.at("resting_channels").empty()) << knock << of;
    }
    damage_log(
        out / "active.lcm", folder_ / "damaged.lcm",
        [from = dies](stillframe_msgs::measurement_t& m) {
          if (m.seq >= from) m.frame_acceleration.at(0) = 0;
        },
        [](const std::string&, int) { return false; });
    const Said said = run({"report", out / "passive.lcm", folder_ / "damaged.lcm", "--json"});
    const Json verdict = Json::parse(said.output);
    EXPECT_NE(verdict.at("outcome"), "passed") << knock;
    EXPECT_EQ(verdict.at("runs")[1].at("resting_channels"),
              Json{dies == 0 ? "mass" : "mass (from 5 to 10 s)"})
        << knock << said.output;
  }
}

TEST_F(VerdictVerbs, WhatALogLacksOrHoldsThatIsNoMeasurementFails) {
  ASSERT_EQ(simulate(folder_ / "run", {"--duration", "12", "--loop", "active"}).exit_code, 0);
  using stillframe_msgs::measurement_t;
  const auto verdict_of = [&](auto&& change, auto&& leave_out) {
    damage_log(folder_ / "run/active.lcm", folder_ / "damaged.lcm", change, leave_out);
    return Json::parse(run({"report", folder_ / "damaged.lcm", "--json"}).output);
  };
  const auto as_it_is = [](measurement_t&) {};
  const auto whole = [](const std::string&, int) { return false; };
  EXPECT_EQ(verdict_of(as_it_is, whole).at("outcome"), "passed");
  const auto expect_failed = [](const Json& verdict, const std::string& part) {
    EXPECT_EQ(verdict.at("outcome"), "failed");
    const auto reason = verdict.at("reason").get<std::string>();
    EXPECT_NE(reason.find(part), std::string::npos) << reason;
  };
  expect_failed(
      verdict_of(as_it_is, [](const std::string& channel,
                              int n) { return channel == channels::command && n % 3 == 0; }),
      "Commands that the log of the active run lacks: ");
  expect_failed(
      verdict_of(
          [](measurement_t& m) {
            if (m.seq == 5000) m.sigma[2] = std::nan("");
          },
          whole),
      "that are not finite, or beyond 1e+12 (N, m/s^2): 1, the first at seq 5000, sigma of ");
  measurement_t kept;
  expect_failed(verdict_of(
                    [&](measurement_t& m) {
                      if (m.seq <= 6000) kept = m;
                      if (m.seq <= 6000 || m.seq > 8000) return;
                      const auto seq = m.seq, time_ns = m.time_ns;
                      m = kept;
                      m.seq = seq, m.time_ns = time_ns;
                    },
                    whole),
                "that repeat the one before in every channel: 2000 of 12001");
  const Json silent = verdict_of(
      as_it_is, [](const std::string& channel, int) { return channel == channels::timing; });
  EXPECT_EQ(silent.at("outcome"), "passed");
  bool said = false;
  for (const Json& check : silent.at("checks")) {
    said = said || (check.at("what") == "measurements that the controller never answered" &&
                    check.at("outcome") == "not judged");
  }
  EXPECT_TRUE(said);
}

TEST_F(VerdictVerbs, ALogWhoseGainsOrSceneCannotBeReadFails) {
  ASSERT_EQ(simulate(folder_ / "run", {"--duration", "12", "--loop", "active"}).exit_code, 0);
  const auto damage = [&](const std::string& name, auto&& change) {
    lcm::LogFile from((folder_ / "run/active.lcm").string(), "r");
    lcm::LogFile to((folder_ / name).string(), "w");
    while (const lcm::LogEvent* event = from.readNextEvent()) {
      lcm::LogEvent copy = *event;
      std::vector<std::uint8_t> bytes;
      if (event->channel == channels::run_info) {
        stillframe_msgs::run_info_t info;
        EXPECT_GE(info.decode(event->data, 0, event->datalen), 0);
        change(info);
        bytes.resize(static_cast<std::size_t>(info.getEncodedSize()));
        info.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
        copy.data = bytes.data();
        copy.datalen = static_cast<std::int32_t>(bytes.size());
      }
      to.writeEvent(&copy);
    }
    return folder_ / name;
  };
  using Info = stillframe_msgs::run_info_t;
  for (const auto& log : {damage("gains.lcm", [](Info& i) { i.gains_text = "K_P: none\n"; }),
                          damage("scene.lcm", [](Info& i) { i.scene_text = "title: {\n"; }),
                          damage("floor.lcm", [](Info& i) { i.floor_text = "quake: now\n"; })}) {
    const Said said = run({"report", log, "--json"});
    EXPECT_EQ(said.exit_code, 4) << log;
    const Json verdict = Json::parse(said.output);
    EXPECT_EQ(verdict.at("outcome"), "failed");
    EXPECT_NE(verdict.at("reason").get<std::string>().find(log.stem().string() + "_text"),
              std::string::npos)
        << verdict.at("reason");
  }
  const Said said =
      run({"report", damage("hash.lcm", [](Info& i) { i.scene_hash = "0"; }), "--json"});
  EXPECT_EQ(said.exit_code, 4);
  EXPECT_NE(Json::parse(said.output).at("reason").get<std::string>().find("scene_hash: found 0"),
            std::string::npos)
      << said.output;
}

TEST(VerdictAgreement, TextJsonBadgeAndExitCodeSayTheSame) {
  std::mt19937 random(14);
  using report::Outcome;
  for (int n = 0; n < 300; ++n) {
    report::Verdict verdict;
    std::vector<report::Check> checks(random() % 6);
    for (report::Check& check : checks) {
      check.subject = static_cast<report::Subject>(random() % 4);
      check.outcome = static_cast<Outcome>(random() % 3);
      if (check.outcome == Outcome::failed && random() % 2 == 0) check.outcome = Outcome::passed;
      check.by_scene = random() % 4 == 0;
      check.reason = "Reason " + std::to_string(random()) + " of <some> \"kind\" & sort.";
    }
    verdict.judgement = report::conclude(checks);
    const std::string word(report::to_text(verdict.judgement.outcome));
    EXPECT_EQ(Json::parse(report::to_json(verdict)).at("outcome"), word);
    EXPECT_NE(report::to_text(verdict).find("Verdict: " + word + ". "), std::string::npos);
    page::PageData data;
    judge::add_judgement(verdict, data.head);
    EXPECT_EQ(badge_of(page::head_html(data)), word);
    EXPECT_EQ(tools::exit_code_of(verdict.judgement.outcome) == 4, word == "failed");
  }
}

// What could be looked at of one loop only is said of the other.
TEST(PredictionChecks, WhatOneLoopLacksIsSaid) {
  report::Verdict verdict;
  for (const char* loop : {"passive", "active"}) {
    verdict.responses.push_back({.loop = loop, .what = "3 floors to 3 frames", .n_compared = 90});
  }
  EXPECT_EQ(judge::prediction_checks({}, verdict, {}).size(), 2u);
  verdict.responses[1].n_compared = 0;
  verdict.responses[1].missing = "no value is known";
  auto checks = judge::prediction_checks({}, verdict, {});
  ASSERT_EQ(checks.size(), 2u);
  EXPECT_EQ(checks[0].outcome, report::Outcome::passed);
  EXPECT_EQ(checks[1].outcome, report::Outcome::not_judged);
  EXPECT_EQ(checks[1].reason,
            "The active loop, 3 floors to 3 frames, is not set against its prediction, which the "
            "other one is: no value is known.");
  verdict.responses[0].n_compared = 0;
  EXPECT_TRUE(judge::prediction_checks({}, verdict, {}).empty());
}

TEST(PredictionChecks, WhatTheSceneAsksForTakesThePlaceOfTheTolerance) {
  report::Verdict verdict;
  verdict.identification = report::IdentificationSummary{.n_frequencies = 50,
                                                         .n_open_compared = 300,
                                                         .n_closed_compared = 300,
                                                         .allowed_db = 0.1,
                                                         .beyond_db = 0.3,
                                                         .n_reduction_frequencies = 9,
                                                         .n_closed_below_open = 9};
  const auto outcome = [&](std::optional<double> prediction_db) {
    const auto checks = judge::prediction_checks({}, verdict, prediction_db);
    EXPECT_EQ(checks.size(), 1u);
    EXPECT_EQ(checks.front().by_scene, prediction_db.has_value());
    return checks.front().outcome;
  };
  using report::Outcome;
  EXPECT_EQ(outcome({}), Outcome::failed);
  EXPECT_EQ(outcome(0.2), Outcome::failed);
  EXPECT_EQ(outcome(0.5), Outcome::passed);
  verdict.identification->beyond_db = std::nan("");
  EXPECT_EQ(outcome(0.5), Outcome::failed);
  verdict.forces_unknown = "blow.csv is gone";
  EXPECT_EQ(outcome(0.5), Outcome::not_judged);
  verdict.forces_unknown.clear();
  verdict.identification->beyond_db = 0;
  const auto reason = [&] { return judge::prediction_checks({}, verdict, {}).front().reason; };
  verdict.identification->n_closed_compared = 0;
  verdict.identification->n_reduction_unknown = 7;
  verdict.identification->n_reduction_frequencies = 0;
  verdict.identification->n_closed_below_open = 0;
  EXPECT_EQ(outcome(0.5), Outcome::not_judged);
  EXPECT_NE(reason().find("No singular value of the active loop is known"), std::string::npos);
  EXPECT_NE(reason().find("is known at none of the 7 frequencies"), std::string::npos) << reason();
  EXPECT_EQ(reason().find("the prediction is that it does so nowhere"), std::string::npos);
  verdict.identification->n_open_compared = 0;
  EXPECT_EQ(outcome(0.5), Outcome::not_judged);
}

TEST(PredictionChecks, ARunThatIsBroadlyOffItsPredictionFails) {
  report::Verdict verdict;
  verdict.responses = {{.loop = "active", .what = "3 inputs to 3 outputs", .n_compared = 140}};
  report::ResponseSummary& response = verdict.responses.front();
  const auto checks = [&](double beyond_db) {
    response.broadly_beyond_db = beyond_db;
    return judge::prediction_checks({}, verdict, {});
  };
  using report::Outcome;
  for (const auto& [beyond_db, outcome] :
       {std::pair(17.5, Outcome::failed), std::pair(3.1, Outcome::failed),
        std::pair(2.9, Outcome::passed), std::pair(std::nan(""), Outcome::failed)}) {
    ASSERT_EQ(checks(beyond_db).size(), 1u);
    EXPECT_EQ(checks(beyond_db).front().outcome, outcome) << beyond_db;
    // It says nothing of isolation.
    EXPECT_FALSE(checks(beyond_db).front().is_proof);
  }
  // A sentence says what came of it.
  EXPECT_NE(checks(2.9).front().reason.find("is broadly the predicted one"), std::string::npos);
  EXPECT_NE(checks(3.1).front().reason.find("is not the predicted one"), std::string::npos);
  // What forces do that nobody knows may be any difference, but no agreement.
  verdict.forces_unknown = "blow.csv is gone";
  EXPECT_EQ(checks(3.1).front().outcome, Outcome::not_judged);
  EXPECT_TRUE(checks(3.1).front().is_needed);
  EXPECT_TRUE(checks(3.1).front().reason.ends_with(
      ", but forces act on the frame besides the floor and may be the difference (what they do is "
      "not known: blow.csv is gone)."))
      << checks(3.1).front().reason;
  EXPECT_EQ(checks(2.9).front().outcome, Outcome::passed);
  verdict.forces_unknown.clear();
  // Where nothing is known, or a floor that nobody measures may do as much, a warning says so.
  response.n_unmeasured = 6;
  EXPECT_EQ(checks(17.5).size(), 1u);
  response.unmeasured_broadly_db = 2.9;
  EXPECT_EQ(checks(17.5).size(), 1u);
  response.unmeasured_broadly_db = 3;
  EXPECT_TRUE(checks(17.5).empty());
  response.unmeasured_broadly_db = 0;
  response.repeats = true;
  EXPECT_TRUE(checks(17.5).empty());
  response.repeats = false;
  response.n_compared = 0;
  EXPECT_TRUE(checks(17.5).empty());
}

// The floor is liveliest where the active frame is worse than the passive one: about the target of
// a frame that hardly moves from 1 Hz on, and above 80 Hz.
TEST_F(VerdictVerbs, AFrameIsJudgedWhereItsModesAre) {
  const auto with = [](const std::string& stiffness, const std::string& controller,
                       const std::string& floor) {
    std::string text = mass_on_a_table(controller, floor);
    text.replace(text.find("4e5"), 3, stiffness);
    return text;
  };
  std::string slow =
      with("51.2", "target_hz: 0.1, sample_rate_hz: 100",
           "floor: {noise: {psd: [[0.05, 1e-6], [0.09, 1e-4], [0.11, 1e-4], [0.15, 1e-6], [40, "
           "1e-6]], duration_s: 300, high_pass_hz: 0.03}}\n");
  slow.replace(slow.find("damping_ratio: 0.7"), 18, "damping_ratio: 0.05");
  slow.replace(slow.find("leak_hz: 0.05"), 13, "leak_hz: 0.0005");
  const std::string fast =
      with("1.69e7", "target_hz: 20, sample_rate_hz: 2000",
           "floor: {noise: {psd: [[1, 1e-6], [80, 1e-6], [90, 1e-12], [380, 1e-12], [400, 1e-6], "
           "[900, 1e-6]], duration_s: 20}}\n");
  for (const auto& [name, text] : {std::pair("slow", slow), std::pair("fast", fast)}) {
    const auto out = folder_ / name;
    const auto scene = write("scene.yaml", text);
    const Said said = run({"run", scene, "--mode", "single_process", "--out", out});
    expect_everywhere(out, said, "failed");
    EXPECT_NE(said.output.find("times as much as the passive frame (rms from "), std::string::npos)
        << said.output;
  }
}

TEST(Headline, SaysWhereTheFrameIsWorseByClass) {
  const auto level = [](double rms, const char* name) {
    return report::MotionLevel{.rms_acceleration = rms, .vibration_class = name};
  };
  report::Verdict verdict;
  verdict.axes = {{"x", level(13, "VC-D"), {}, level(1, "VC-C")},
                  {"y", level(26, "VC-D"), {}, level(1, "VC-D")},
                  {"z", level(26, "VC-A"), {}, level(1, "above VC-A")}};
  page::Head head;
  judge::add_judgement(verdict, head);
  ASSERT_EQ(head.headlines.size(), 1u);
  EXPECT_NE(head.headlines[0].find("13 times less"), std::string::npos);
  EXPECT_NE(
      head.headlines[0].find("but by vibration class it is worse in x (VC-C for the floor's VC-D), "
                             "z (above VC-A for the floor's VC-A)"),
      std::string::npos)
      << head.headlines[0];
}

}  // namespace
}  // namespace stillframe::test
