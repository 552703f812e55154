#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/control_loop.hpp"
#include "core/modes.hpp"
#include "core/scene/scene_reader.hpp"
#include "core/yaml/input_error.hpp"
#include "plant_sim/floor/floor_block.hpp"

// docs/scene.md is held to the reader: the same keys, the same required ones, and an example that
// works.
namespace stillframe::test {
namespace {

std::string reference() {
  std::ifstream file(STILLFRAME_SOURCE_DIR "/docs/scene.md");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Key to default of every table, by the heading above it.
std::map<std::string, std::map<std::string, std::string>> tables() {
  std::map<std::string, std::map<std::string, std::string>> result;
  std::istringstream text(reference());
  std::string line, heading;
  while (std::getline(text, line)) {
    if (line.starts_with("### ")) heading = line.substr(4);
    if (!line.starts_with("| `")) continue;
    std::vector<std::string> cells;
    std::istringstream row(line.substr(1));
    for (std::string cell; std::getline(row, cell, '|');) {
      const size_t first = cell.find_first_not_of(' '), last = cell.find_last_not_of(' ');
      cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
    }
    EXPECT_EQ(cells.size(), 5u) << line;
    const std::string key = cells[0].substr(1, cells[0].size() - 2);
    EXPECT_TRUE(result[heading].emplace(key, cells[2]).second)
        << heading << ": " << key << " stands twice";
  }
  return result;
}

/// A scene with at least one map of every kind, and in each every key that can stand there
/// together.
const char* const full_scene = R"(
title: Everything
nodes:
  floor: {position: [0, 0, 0]}
  body: {position: [0, 0, 1]}
  side: {position: [1, 0, 1]}
  wall: {position: [2, 0, 1]}
masses:
  - {node: body, mass: 1, inertia: [1, 1, 1]}
elements:
  leg: {type: truss, nodes: [floor, body], stiffness: 1, damping: 1, preload: 0}
  arm: {type: rigid_beam, nodes: [body, side]}
supports:
  - {nodes: [body, wall], fix: [x, y]}
prescribed:
  - {nodes: [floor], move: [x, y, z]}
dofs:
  - {element: leg}
loads:
  - {node: body, force: [0, 0, 0]}
inputs:
  - {name: w, acceleration: floor, along: z}
outputs:
  - {name: y, acceleration: body, along: z}
monitors:
  - {name: m, acceleration: side, along: z}
compare:
  z: {floor: y, frame: m}
controller: {legs: [leg], target_hz: 1, damping_ratio: 1, order: exact, realisation: naive_pi,
  sample_rate_hz: 100, delay_samples: 0, leak_hz: 0, lead_samples: 1, roll_off_hz: 10, force_limit_n: 1}
simulation: {duration_s: 1, relative_tolerance: 1e-6}
)";

const char* const full_floor = R"(
recording: {file: x.csv, scale: 1, start_s: 0, high_pass_hz: 1, axes: {a: x}}
multisine: {frequencies_hz: [1], amplitude: 1, ramp_s: 1, window_s: 4}
white: {seed: 1, rms: 1, high_pass_hz: 1, duration_s: 1}
still: {duration_s: 1}
)";

using Path = std::vector<std::string>;

/// Where the map of each table stands in the full scene ("#0" is the first item of a sequence).
const std::map<std::string, Path> places = {
    {"The scene", {}},
    {"nodes", {"nodes", "floor"}},
    {"masses", {"masses", "#0"}},
    {"elements: truss", {"elements", "leg"}},
    {"elements: rigid_beam", {"elements", "arm"}},
    {"supports", {"supports", "#0"}},
    {"prescribed", {"prescribed", "#0"}},
    {"dofs", {"dofs", "#0"}},
    {"loads", {"loads", "#0"}},
    {"inputs", {"inputs", "#0"}},
    {"outputs and monitors", {"outputs", "#0"}},
    {"compare", {"compare", "z"}},
    {"controller", {"controller"}},
    {"simulation", {"simulation"}},
    {"floor", {}},
    {"floor: recording", {"recording"}},
    {"floor: multisine", {"multisine"}},
    {"floor: white", {"white"}},
    {"floor: still", {"still"}},
};

bool is_floor(const std::string& table) { return table.starts_with("floor"); }

/// The document of a table; a floor has one kind only.
YAML::Node document(const std::string& table) {
  if (!is_floor(table)) return YAML::Load(full_scene);
  YAML::Node all = YAML::Load(full_floor), one;
  const Path& path = places.at(table);
  const std::string kind = path.empty() ? "still" : path.front();
  one[kind] = all[kind];
  return one;
}

YAML::Node map_of(YAML::Node node, const std::string& table) {
  for (const std::string& step : places.at(table)) {
    node.reset(step == "#0" ? node[0] : node[step]);
  }
  return node;
}

/// The reader's message, or nothing if it takes the document.
std::string error_of(const std::string& table, const YAML::Node& node) {
  try {
    if (is_floor(table)) {
      floor::read_floor_block(YamlReader::from_text(YAML::Dump(node), "floor.yaml"), 1000, 1);
    } else {
      parse_scene(YAML::Dump(node), "scene.yaml");
    }
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::set<std::string> allowed_keys(const std::string& message) {
  const std::string marker = "; allowed: ";
  const size_t at = message.find(marker);
  EXPECT_NE(at, std::string::npos) << message;
  std::set<std::string> keys;
  std::istringstream list(message.substr(at + marker.size()));
  for (std::string key; std::getline(list, key, ',');)
    keys.insert(key.substr(key.find_first_not_of(' ')));
  return keys;
}

TEST(SceneReference, HasATableForEveryMapAndNoOther) {
  for (const auto& [heading, rows] : tables()) EXPECT_TRUE(places.contains(heading)) << heading;
  for (const auto& [heading, path] : places) EXPECT_TRUE(tables().contains(heading)) << heading;
}

TEST(SceneReference, TheFullDocumentsAreAccepted) {
  for (const auto& [table, path] : places) EXPECT_EQ(error_of(table, document(table)), "") << table;
}

TEST(SceneReference, ListsExactlyTheKeysThatTheReaderAllows) {
  for (const auto& [table, rows] : tables()) {
    YAML::Node node = document(table);
    map_of(node, table)["no_such_key"] = 1;
    std::set<std::string> documented;
    for (const auto& [key, otherwise] : rows) documented.insert(key);
    EXPECT_EQ(allowed_keys(error_of(table, node)), documented) << table;
  }
}

TEST(SceneReference, SaysWhichKeysAreRequired) {
  for (const auto& [table, rows] : tables()) {
    for (const auto& [key, otherwise] : rows) {
      YAML::Node node = document(table);
      if (!map_of(node, table)[key] || otherwise.starts_with("one of")) continue;
      map_of(node, table).remove(key);
      const std::string message = error_of(table, node);
      if (otherwise.starts_with("required")) {
        EXPECT_NE(message.find(key), std::string::npos) << table << ": " << key << ": " << message;
      } else if (key != "outputs" && key != "monitors") {  // compare refers to both
        EXPECT_EQ(message, "") << table << ": " << key;
      }
    }
  }
}

TEST(SceneReference, NumbersAmongTheDefaultsAreThoseOfTheReader) {
  const auto all = tables();
  EXPECT_EQ(SceneSimulation().relative_tolerance,
            std::stod(all.at("simulation").at("relative_tolerance")));
  EXPECT_EQ(all.at("controller").at("order"), "`exact`");
  EXPECT_EQ(SceneController().order, GainOrder::exact);
  EXPECT_EQ(all.at("controller").at("realisation"), "`implicit_feedthrough`");
  EXPECT_EQ(SceneController().realisation, Realisation::implicit_feedthrough);
  EXPECT_EQ(SceneController().lead_samples, std::stod(all.at("controller").at("lead_samples")));
  EXPECT_EQ(SceneElement().damping, std::stod(all.at("elements: truss").at("damping")));
  EXPECT_EQ(SceneElement().preload, std::stod(all.at("elements: truss").at("preload")));
  const floor::RecordingSpec recording{
      .block = YamlReader::from_text("{}", ""), .file = {}, .axes = {}};
  EXPECT_EQ(recording.scale, std::stod(all.at("floor: recording").at("scale")));
  EXPECT_EQ(recording.start_s, std::stod(all.at("floor: recording").at("start_s")));
  EXPECT_EQ(recording.high_pass_hz, std::stod(all.at("floor: recording").at("high_pass_hz")));
  EXPECT_EQ(MultisinePlan().ramp_s, std::stod(all.at("floor: multisine").at("ramp_s")));
  EXPECT_EQ(MultisinePlan().window_s, std::stod(all.at("floor: multisine").at("window_s")));
  EXPECT_EQ(floor::WhiteSpec().seed, 1u);
  EXPECT_EQ(floor::WhiteSpec().high_pass_hz, std::stod(all.at("floor: white").at("high_pass_hz")));
}

TEST(SceneReference, TheFirstSceneDoesWhatTheTextSays) {
  const std::string text = reference(), fence = "```yaml\n";
  const size_t from = text.find(fence) + fence.size(), to = text.find("```", from);
  ASSERT_LT(from, to);
  const std::string example = text.substr(from, to - from);
  const Scene scene = parse_scene(example, "docs/scene.md");
  const Model model = make_model(scene);
  EXPECT_EQ(model.n_c, 1);  // the count in the text: one coordinate left, one condition
  EXPECT_EQ(model.n_r, 1);
  const ControlLoop loop = make_control_loop(scene, model);
  EXPECT_NEAR(modes(loop.plant).natural_frequencies_hz(0), 31.8, 0.05);
  EXPECT_NE(text.find("31.8 Hz"), std::string::npos);
  const auto root = YamlReader::from_text(example, "docs/scene.md");
  EXPECT_NO_THROW(
      floor::read_floor_block(root.require("floor"), scene.controller->sample_rate_hz, 1));
}

}  // namespace
}  // namespace stillframe::test
