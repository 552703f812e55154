#include "judge/floor_nodes.hpp"
#include "tests/tools/damaged_log.hpp"
#include "tests/tools/three_feet.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;
using judge::FloorNodes;
using stillframe_msgs::measurement_t;

TEST(FloorNodes, GoByWhatTheFloorMoves) {
  const std::string noise = "noise: {vc: C, duration_s: 10", step = "step: {height: 1, rise_s: 1, ";
  const std::string lines = "multisine: {frequencies_hz: [1], amplitude: 1}";
  const auto all = [](const std::string& a, const std::string& b) {
    return "sum: [{" + a + "}, {" + b + "}]";
  };
  const std::pair<std::string, FloorNodes> floors[] = {
      {"recording: {file: none.csv, axes: {a: x}}", FloorNodes::follow},
      {noise + ", axes: [x]}", FloorNodes::follow},
      {step + "axis: rz}", FloorNodes::follow},
      {"still: {duration_s: 10}", FloorNodes::follow},
      {all("still: {duration_s: 10}", step + "axis: x}"), FloorNodes::follow},
      {noise + "}", FloorNodes::rest},
      {"white: {rms: 1, duration_s: 10}", FloorNodes::rest},
      {lines, FloorNodes::rest},
      {step + "input: b}", FloorNodes::rest},
      {all("still: {duration_s: 10}", step + "input: b}"), FloorNodes::rest},
      {all(lines, step + "input: b}"), FloorNodes::rest},
      {all(lines, noise + ", axes: [x]}"), FloorNodes::unknown},
      {all(step + "axis: z}", step + "input: a}"), FloorNodes::unknown}};
  for (const auto& [text, nodes] : floors) {
    const auto spec = floor::read_floor_block(YamlReader::from_text(text, "floor"), 1000,
                                              std::vector<std::string>{"a", "b"});
    EXPECT_EQ(judge::floor_nodes(spec), nodes) << text;
  }
}

/// A table on two feet and a third beside it, of which one along y and one along x are inputs, and
/// two others are watched.
class FeetApart : public Verb {
 protected:
  Json judged(const std::string& floor) const {
    const std::string scene = three_feet("0.05") + R"(gravity: [0, -9.81]
inputs: [{name: fl_y, acceleration: fl, along: y}, {name: fs_x, acceleration: fs, along: x}]
monitors: [{name: g_x, acceleration: fs, along: x}, {name: g_y, acceleration: fl, along: y},
  {name: l_x, acceleration: fl, along: x}, {name: r_y, acceleration: fr, along: y}]
controller: {legs: [left, right, side], target_hz: 3, damping_ratio: 0.7, sample_rate_hz: 1000,
  delay_samples: 1, leak_hz: 0.6}
floor: {)";
    std::filesystem::remove_all(out());
    const Said said = run({"run", write("scene.yaml", scene + floor + "}\n"), "--mode",
                           "single_process", "--out", out()});
    EXPECT_NE(said.exit_code, 2) << said.error;
    return Json::parse(text_of(out() / "verdict.json"));
  }

  std::filesystem::path out() const { return folder_ / "run"; }

  static Json resting(const Json& verdict) {
    Json all = Json::array();
    for (const Json& of : verdict.at("runs")) all.push_back(of.at("resting_channels"));
    return all;
  }
};

const std::string sweep =
    "sine_sweep: {from_hz: 1, to_hz: 100, amplitude: 0.002, sweep_s: 20, input: fs_x}";
const Json none = {Json::array(), Json::array()};

// The other feet were taken along: 15 % of a frame without noise was "noise", and their monitors
// dead.
TEST_F(FeetApart, AFootThatMovesAloneTakesNoOtherAlong) {
  const Json verdict = judged(sweep);
  EXPECT_EQ(resting(verdict), none) << verdict.at("runs");
  EXPECT_EQ(verdict.at("outcome"), "passed") << verdict.at("reason");
  for (const Json& noise : verdict.at("noise")) {
    if (noise.at("axis") != "x") continue;  // along y the floor rests
    ASSERT_FALSE(noise.at("share").is_null()) << noise;
    // 3e-4 of tolerance, of a frame whose floor it isolates from: ten times that.
    EXPECT_LT(noise.at("share").get<double>(), 3e-3) << noise;
  }
  // What does have to move is found as before: the frame, and the foot that moves. A log has the
  // outputs before the monitors.
  for (const auto& [channel, name] : {std::pair(0, "c_x"), {2, "g_x"}}) {
    damage_log(
        out() / "active.lcm", folder_ / "damaged.lcm",
        [&](measurement_t& m) { m.frame_acceleration.at(static_cast<std::size_t>(channel)) = 0; },
        [](const std::string&, int) { return false; });
    const Json damaged = Json::parse(run({"report", out() / "passive.lcm", folder_ / "damaged.lcm",
                                          "--out", folder_ / "page.html", "--json"})
                                         .output);
    EXPECT_EQ(resting(damaged), Json({Json::array(), Json{name}}));
    EXPECT_NE(damaged.at("outcome"), "passed") << name;
  }
}

// The axes were predicted of a floor of which all feet move: a sound run failed by 14 dB.
TEST_F(FeetApart, AnAxisIsPredictedOfTheFloorThatWas) {
  const Json verdict = judged("noise: {vc: C, duration_s: 60, seed: 5, high_pass_hz: 0.5}");
  EXPECT_NE(verdict.at("outcome"), "failed") << verdict.at("reason");
  int n = 0;
  for (const Json& response : verdict.at("responses")) {
    if (response.at("what") == "2 floors to 2 frames") n += response.at("n_compared").get<int>();
    // To what a model is taken to be known to (ComparisonRule).
    EXPECT_LT(response.at("beyond_db").get<double>(), 0.1) << response;
  }
  EXPECT_GE(n, 50);  // half of the values of both loops at 50 frequencies
}

// No signal tells what of an input is the axis' motion, and what its own.
TEST_F(FeetApart, WhatBothMoveIsNotKnown) {
  const Json verdict =
      judged("sum: [{" + sweep + "}, {noise: {vc: C, axes: [y], duration_s: 20, seed: 5}}]");
  EXPECT_EQ(resting(verdict), none) << verdict.at("runs");  // l_x rests, and may
  for (const Json& noise : verdict.at("noise")) {
    EXPECT_TRUE(noise.at("share").is_null()) << noise;
    EXPECT_NE(noise.at("missing").get<std::string>().find("moves axes and single inputs at once"),
              std::string::npos)
        << noise;
  }
}

// What lies beyond its band on a multisine is not the doing of feet that rest. It is distortion
// here, of 4 m/s^2 at 2 Hz: 25 mm of motion on legs of 250 mm.
TEST_F(FeetApart, NoFootIsBlamedThatRests) {
  const std::string lines = "multisine: {frequencies_hz: [2, 5, 10, 20], amplitude: 4}";
  const std::string noise = "noise: {vc: C, axes: [y], duration_s: 20}";
  for (const auto& [floor, blames] :
       {std::pair(lines, false), {"sum: [{" + lines + "}, {" + noise + "}]", true}}) {
    std::string all;
    const Json verdict = judged(floor);
    for (const Json& warning : verdict.at("warnings")) all += warning.get<std::string>();
    EXPECT_NE(all.find("is not what the model says"), std::string::npos) << all;
    const bool found =
        all.find("The floor's nodes can also move in 4 directions") != std::string::npos;
    EXPECT_EQ(found, blames) << floor << all;
  }
}

}  // namespace
}  // namespace stillframe::test
