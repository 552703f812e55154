#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <numbers>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/control/design/control_loop.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/body_file.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/numerics/worst.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "tests/support/scratch_folder.hpp"

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
planar: false
gravity: [0, 0, 0]
operating_point: as_written
nodes:
  floor: {position: [0, 0, 0]}
  body: {position: [0, 0, 1]}
  side: {position: [1, 0, 1]}
  turned: {position: [1, 0, 1]}
  wall: {position: [2, 0, 1]}
  mount_1: {position: [0.6, 0, -0.1]}
  mount_2: {position: [-0.3, 0.519615242270663, -0.1]}
  mount_3: {position: [-0.3, -0.519615242270663, -0.1]}
  lens: {position: [0, 0, 0.05]}
masses:
  - {node: body, mass: 1, inertia: [1, 1, 1]}
elements:
  leg: {type: truss, nodes: [floor, body], stiffness: 1, damping: 1, preload: 0}
  arm: {type: rigid_beam, nodes: [body, side]}
  joint: {type: hinge, nodes: [side, turned], axis: z, rigid: [2], stiffness: [1, 0, 0],
    damping: [1, 0, 0], preload: [1, 0, 0]}
  spring: {type: beam, nodes: [turned, wall], orientation: z, EA: 1, GJ: 1, EI_y: 1, EI_z: 1,
    shear_y: 1, shear_z: 1, mass_per_length: 1, inertia_per_length: 1, mass: lumped,
    second_order: true, stiffness: [1, 0, 0, 0, 0, 0], damping: [1, 0, 0, 0, 0, 0],
    damping_time: 1, rigid: [], preload: [0, 0, 0, 0, 0, 0], divide: 2}
  plate: {type: superelement, nodes: [mount_1, mount_2, mount_3, lens], damping_time: 1e-6,
    body: )" STILLFRAME_SOURCE_DIR R"(/config/bodies/plate.yaml}
supports:
  - {nodes: [body, wall], fix: [x, y]}
prescribed:
  - {nodes: [floor], move: [x, y, z], value: 1, rate: 1, acceleration: 1}
dofs:
  - {element: leg, mode: 1, value: 1, rate: 1}
loads:
  - {node: body, force: [0, 0, 0], torque: [0, 0, 0], follows: true}
inputs:
  - {name: w, acceleration: floor, along: z}
outputs:
  - {name: y, acceleration: body, along: z}
monitors:
  - {name: m, acceleration: side, along: z}
compare:
  z: {floor: y, frame: m}
controller: {legs: [leg], target_hz: 1, damping_ratio: 1, order: exact, reduction: modes, realisation: naive_pi,
  sample_rate_hz: 100, delay_samples: 0, leak_hz: 0, high_pass_hz: 0, lead_samples: 1, roll_off_hz: 10, force_limit_n: 1,
  feed_forward: {to_hz: 5, corner_hz: 0.1, target_hz: 2, damping_ratio: 0.7, at_most_db: -10, actuator_error: 0.02, noise_over_floor: 1e-3, taps: 16},
  law: )" STILLFRAME_SOURCE_DIR R"(/config/controllers/force_feedback_5hz.yaml}
accept: {axes: {z: {class: VC-E, rms_of_floor: 0.5, rms_of_passive: 0.5, band_of_floor: 1,
  band_of_passive: 1, from_hz: 10, to_hz: 50}}, limited_share: 0.01, lost_share: 0,
  discarded_share: 0, prediction_db: 1}
instruments: {actuator_gain: 1, actuator_lag_hz: 300, sensor_filter_hz: 400,
  applied_force: measured, report_age_samples: 0, force_rate_limit_n_per_s: 1e3,
  hysteresis: {width: 0.1, swing_n: 1, saturation_n: 1, gamma_over_beta: 0},
  force_sensors: {noise_n_per_sqrt_hz: 1e-3, flicker_below_hz: 1, offset_n: [0], drift_n_per_s: 0,
    random_walk_n_per_sqrt_s: 0, range_n: 1, quantisation_n: 1e-3, seed: 1},
  floor_sensors: {noise: 1e-6, seed: 1}}
disturbances:
  - {name: a, node: body, along: z, force: {step: {at_s: 1, height: 1, rise_s: 1}}}
  - {name: b, node: body, along: z, force: {impact: {at_s: 1, peak: 1, width_s: 1}}}
  - {name: c, node: body, along: z, force: {sine: {at_s: 1, amplitude: 1, frequency_hz: 1}}}
  - {name: d, node: body, along: z, force: {sine_sweep: {at_s: 1, amplitude: 1, from_hz: 1,
      to_hz: 2, sweep_s: 9, spacing: linear}}}
  - {name: e, node: body, along: z, force: {noise: {at_s: 1, psd: [[1, 1], [2, 1]], seed: 2,
      period_s: 9}}}
  - {name: f, node: body, along: z, force: {recording: {at_s: 1, file: a.csv, column: a, scale: 2,
      start_s: 1}}}
reduce: {modes: 3, to_hz: 20}
uncertainty: {stiffness: 0.1, damping: 0.2, mass: 0.1, inertia: 0.1, centre_of_mass_m: 0.01,
  leg_direction_rad: 0.01, actuator_gain: 0.1, sensor_gain: 0.1, delay_samples: 0.2}
corrections: {stiffness: {leg: 0.1}, damping: {leg: -0.1}, mass: {body: 0.1}, inertia: {body: 0.1},
  centre_of_mass_m: {body: [0, 0, 0.01]}, leg_direction_rad: {leg: [0.01, 0]}, delay_samples: 0.1}
simulation: {duration_s: 1, relative_tolerance: 1e-6, method: dormand_prince}
)";

const char* const full_planar_scene = R"(
title: Everything in a plane
planar: true
nodes:
  clamp: {position: [0, 0]}
  tip: {position: [1, 0]}
masses: []
elements:
  strip: {type: beam, nodes: [clamp, tip], EA: 1, EI: 1, shear: 1, mass_per_length: 1, mass: lumped,
    second_order: true, stiffness: [1, 0, 0], damping: [1, 0, 0], damping_time: 1, rigid: [],
    preload: [0, 0, 0], divide: 2}
dofs: auto
)";

const char* const full_floor = R"(
recording: {file: x.csv, scale: 1, start_s: 0, high_pass_hz: 1, axes: {a: x}}
multisine: {frequencies_hz: [1], amplitude: 1, ramp_s: 1, window_s: 4}
white: {seed: 1, rms: 1, high_pass_hz: 1, duration_s: 1}
noise: {psd: [[1, 1], [2, 1]], seed: 1, high_pass_hz: 1, period_s: 1, duration_s: 1, axes: [x, rx]}
step: {height: 1, rise_s: 1, at_s: 1, axis: x, duration_s: 3}
impact: {peak: 1, width_s: 1, at_s: 1, axis: x, duration_s: 3}
sine_sweep: {from_hz: 5, to_hz: 9, amplitude: 1, sweep_s: 1, spacing: linear, at_s: 1, axis: rz,
  about: [0, 0, 0], duration_s: 3}
still: {duration_s: 1}
)";

using Path = std::vector<std::string>;

/// Where the map of each table stands in the full scene ("#0" is the first item of a sequence).
const std::map<std::string, Path> places = {
    {"The scene", {}},
    {"nodes", {"nodes", "floor"}},
    {"masses", {"masses", "#0"}},
    {"elements: truss", {"elements", "leg"}},
    {"elements: beam", {"elements", "spring"}},
    {"elements: beam, planar", {"elements", "strip"}},
    {"elements: hinge", {"elements", "joint"}},
    {"elements: superelement", {"elements", "plate"}},
    {"elements: superelement, body file", {}},
    {"elements: rigid_beam", {"elements", "arm"}},
    {"supports", {"supports", "#0"}},
    {"prescribed", {"prescribed", "#0"}},
    {"dofs", {"dofs", "#0"}},
    {"loads", {"loads", "#0"}},
    {"inputs", {"inputs", "#0"}},
    {"outputs and monitors", {"outputs", "#0"}},
    {"compare", {"compare", "z"}},
    {"accept", {"accept"}},
    {"accept: axes", {"accept", "axes", "z"}},
    {"controller", {"controller"}},
    {"controller: feed_forward", {"controller", "feed_forward"}},
    {"instruments", {"instruments"}},
    {"instruments: hysteresis", {"instruments", "hysteresis"}},
    {"instruments: force_sensors", {"instruments", "force_sensors"}},
    {"instruments: floor_sensors", {"instruments", "floor_sensors"}},
    {"uncertainty", {"uncertainty"}},
    {"corrections", {"corrections"}},
    {"reduce", {"reduce"}},
    {"simulation", {"simulation"}},
    {"disturbances", {"disturbances", "#0"}},
    {"disturbances: force", {"disturbances", "#0", "force"}},
    {"disturbances: step", {"disturbances", "#0", "force", "step"}},
    {"disturbances: impact", {"disturbances", "#1", "force", "impact"}},
    {"disturbances: sine", {"disturbances", "#2", "force", "sine"}},
    {"disturbances: sine_sweep", {"disturbances", "#3", "force", "sine_sweep"}},
    {"disturbances: noise", {"disturbances", "#4", "force", "noise"}},
    {"disturbances: recording", {"disturbances", "#5", "force", "recording"}},
    {"floor", {}},
    {"floor: recording", {"recording"}},
    {"floor: multisine", {"multisine"}},
    {"floor: white", {"white"}},
    {"floor: noise", {"noise"}},
    {"floor: step", {"step"}},
    {"floor: impact", {"impact"}},
    {"floor: sine_sweep", {"sine_sweep"}},
    {"floor: still", {"still"}},
};

bool is_floor(const std::string& table) { return table.starts_with("floor"); }
bool is_planar(const std::string& table) { return table.ends_with(", planar"); }
bool is_body(const std::string& table) { return table.ends_with(", body file"); }

/// The document of a table; a floor has one kind only.
YAML::Node document(const std::string& table) {
  if (is_body(table)) {
    const std::string folder = STILLFRAME_SOURCE_DIR "/config/bodies/";
    YAML::Node body = YAML::LoadFile(folder + "plate.yaml");
    for (const char* key : {"mass_matrix", "stiffness_matrix"}) {
      body[key] = folder + body[key].as<std::string>();
    }
    return body;
  }
  if (!is_floor(table)) {
    YAML::Node scene = YAML::Load(is_planar(table) ? full_planar_scene : full_scene);
    // A correction is refused without the number that it corrects.
    if (table != "The scene" && table != "corrections") scene.remove("corrections");
    return scene;
  }
  YAML::Node all = YAML::Load(full_floor), one;
  const Path& path = places.at(table);
  const std::string kind = path.empty() ? "still" : path.front();
  one[kind] = all[kind];
  return one;
}

YAML::Node map_of(YAML::Node node, const std::string& table) {
  for (const std::string& step : places.at(table)) {
    node.reset(step.starts_with('#') ? node[std::stoi(step.substr(1))] : node[step]);
  }
  return node;
}

/// The reader's message, or nothing if it takes the document.
std::string error_of(const std::string& table, const YAML::Node& node) {
  try {
    if (is_floor(table)) {
      floor::read_floor_block(YamlReader::from_text(YAML::Dump(node), "floor.yaml"), 1000, 1);
    } else if (is_body(table)) {
      const ScratchFolder folder;
      std::vector<ReadFile> files;
      const auto file = folder.write("body.yaml", YAML::Dump(node));
      read_flexible_body(YamlReader::from_text(file.string(), "scene.yaml"), files);
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
      } else if (key != "outputs" && key != "monitors" && key != "operating_point" &&
                 key != "noise_n_per_sqrt_hz" && key != "compare" && key != "modes") {
        // compare refers to the outputs and monitors, the value of a dof needs its operating point,
        // flicker its noise, what is accepted what it is about, matrices have rows for their modes
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
  const auto& forward = all.at("controller: feed_forward");
  EXPECT_EQ(SceneFeedForward().at_most_db, std::stod(forward.at("at_most_db")));
  EXPECT_EQ(SceneFeedForward().actuator_error, std::stod(forward.at("actuator_error")));
  EXPECT_EQ(SceneFeedForward().noise_over_floor, std::stod(forward.at("noise_over_floor")));
  EXPECT_EQ(SceneFeedForward().taps, std::stoi(forward.at("taps")));
  for (const char* const table : {"elements: beam", "elements: beam, planar"}) {
    const auto& beam = all.at(table);
    EXPECT_EQ(SceneBeam().mass_per_length, std::stod(beam.at("mass_per_length")));
    EXPECT_EQ(SceneBeam().damping_time, std::stod(beam.at("damping_time")));
    EXPECT_EQ(beam.at("mass"), "`consistent`");
    EXPECT_FALSE(SceneBeam().lumped_mass);
    EXPECT_EQ(beam.at("second_order"), "false");
    EXPECT_FALSE(SceneBeam().second_order);
  }
  EXPECT_EQ(SceneBeam().inertia_per_length,
            std::stod(all.at("elements: beam").at("inertia_per_length")));
  EXPECT_EQ(all.at("The scene").at("planar"), "false");
  EXPECT_FALSE(Scene().planar);
  EXPECT_EQ(all.at("The scene").at("operating_point"), "`equilibrium`");
  EXPECT_EQ(Scene().operating_point, OperatingPoint::equilibrium);
  EXPECT_EQ(all.at("loads").at("follows"), "false");
  EXPECT_FALSE(SceneLoad().follows);
  for (const char* const table : {"inputs", "outputs and monitors"}) {
    EXPECT_EQ(SceneSignal().mode, std::stoi(all.at(table).at("mode")));
  }
  for (const char* const key : {"value", "rate", "acceleration"}) {
    EXPECT_EQ(0, std::stod(all.at("prescribed").at(key))) << key;
  }
  EXPECT_EQ(SceneConstraint().value, 0);
  EXPECT_EQ(SceneConstraint().rate, 0);
  EXPECT_EQ(SceneConstraint().acceleration, 0);
  const floor::RecordingSpec recording{
      .block = YamlReader::from_text("{}", ""), .file = {}, .axes = {}};
  EXPECT_EQ(recording.scale, std::stod(all.at("floor: recording").at("scale")));
  EXPECT_EQ(recording.start_s, std::stod(all.at("floor: recording").at("start_s")));
  EXPECT_EQ(recording.high_pass_hz, std::stod(all.at("floor: recording").at("high_pass_hz")));
  EXPECT_EQ(MultisinePlan().ramp_s, std::stod(all.at("floor: multisine").at("ramp_s")));
  EXPECT_EQ(MultisinePlan().window_s, std::stod(all.at("floor: multisine").at("window_s")));
  EXPECT_EQ(floor::NoiseSpec().high_pass_hz, std::stod(all.at("floor: noise").at("high_pass_hz")));
  EXPECT_EQ(floor::NoiseSpec().period_s, std::stod(all.at("floor: noise").at("period_s")));
  EXPECT_EQ(ForceNoise().period_s, std::stod(all.at("disturbances: noise").at("period_s")));
  EXPECT_EQ(ForceNoise().seed, std::stoull(all.at("disturbances: noise").at("seed")));
  EXPECT_EQ(ForceRecording().scale, std::stod(all.at("disturbances: recording").at("scale")));
  EXPECT_EQ(ForceStep().rise_s, std::stod(all.at("disturbances: step").at("rise_s")));
  EXPECT_EQ(floor::WhiteSpec().seed, 1u);
  EXPECT_EQ(floor::WhiteSpec().high_pass_hz, std::stod(all.at("floor: white").at("high_pass_hz")));
}

TEST(SceneReference, ListsTheMethodsOfThePlantThatThereAre) {
  std::string names;
  for (const NamedPlantMethod& each : plant_methods) {
    names += (names.empty() ? "`" : ", `") + std::string(each.name) + "`";
    YAML::Node node = YAML::Load(full_scene);
    node["simulation"]["method"] = std::string(each.name);
    EXPECT_EQ(parse_scene(YAML::Dump(node), "scene.yaml").simulation.method, each.method);
    EXPECT_EQ(method_name(each.method), each.name);
  }
  const std::string row =
      "| `method` | | `" + method_name(SceneSimulation().method) + "` | " + names + " |";
  EXPECT_NE(reference().find(row), std::string::npos) << row;
}

/// Elements without their optional keys have the defaults of the tables.
TEST(SceneReference, DefaultsOfElementsAreThoseOfTheReader) {
  const auto all = tables();
  for (const char* const name : {"leg", "joint"}) {
    YAML::Node node = document("elements: truss");
    YAML::Node map = node["elements"][name];
    for (const char* const key : {"rigid", "damping", "preload"}) map.remove(key);
    if (std::string(name) == "joint") map.remove("stiffness");
    const Scene scene = parse_scene(YAML::Dump(node), "scene.yaml");
    for (const SceneElement& element : scene.elements) {
      if (element.name != name) continue;
      const bool truss = element.kind == SceneElement::Kind::truss;
      const auto& table = all.at(truss ? "elements: truss" : "elements: hinge");
      EXPECT_EQ(element.damping.sum(), std::stod(table.at("damping"))) << name;
      EXPECT_EQ(element.preload.sum(), std::stod(table.at("preload"))) << name;
      EXPECT_EQ(table.at("rigid"), truss ? "false" : "`[2, 3]`");
      EXPECT_EQ(element.zero,
                truss ? std::vector<bool>{false} : (std::vector<bool>{false, true, true}));
    }
  }
  EXPECT_EQ(all.at("elements: beam").at("divide"), "1");
}

/// The n-th example of the text, from 0.
std::string example(int n) {
  const std::string text = reference(), fence = "```yaml\n";
  size_t from = text.find(fence) + fence.size();
  for (int i = 0; i < n; ++i) from = text.find(fence, from) + fence.size();
  const size_t to = text.find("```", from);
  EXPECT_LT(from, to);
  return text.substr(from, to - from);
}

TEST(SceneReference, TheFirstSceneDoesWhatTheTextSays) {
  const Scene scene = parse_scene(example(0), "docs/scene.md");
  const Model model = make_model(scene);
  EXPECT_EQ(model.n_c, 1);  // the count in the text: one coordinate left, one condition
  EXPECT_EQ(model.n_r, 1);
  const ControlLoop loop = make_control_loop(scene, model);
  EXPECT_NEAR(modes(loop.plant).natural_frequencies_hz(0), 31.8, 0.05);
  EXPECT_NE(reference().find("31.8 Hz"), std::string::npos);
  const auto root = YamlReader::from_text(example(0), "docs/scene.md");
  EXPECT_NO_THROW(
      floor::read_floor_block(root.require("floor"), scene.controller->sample_rate_hz, 1));
}

TEST(SceneReference, TheFlexibleBeamDoesWhatTheTextSays) {
  const Scene scene = parse_scene(example(1), "docs/scene.md");
  const Model model = make_model(scene);
  EXPECT_EQ(model.n_c, 12);  // the count in the text
  EXPECT_EQ(model.n_d, 12);
  const auto frequencies = modes(linearise(model, {}, {})).natural_frequencies_hz;
  // A clamped beam, in root(EI / (mass_per_length L^4)) / 2 pi; 0.2 % is what the text says.
  const double unit = std::sqrt(0.3333 / (0.156 * std::pow(0.2, 4))) / (2 * std::numbers::pi);
  EXPECT_NEAR(frequencies(0), 3.516015 * unit, 2e-3 * 3.516015 * unit);
  EXPECT_NEAR(frequencies(1), 22.034492 * unit, 2e-3 * 22.034492 * unit);
  // The choice of dofs changes no natural frequency; 1e-9 is the rounding of highest over lowest.
  std::string automatic = example(1);
  const std::string dofs = "  - {deformations: strip}\n";
  automatic.replace(automatic.find("dofs:"),
                    automatic.find(dofs) + dofs.size() - automatic.find("dofs:"), "dofs: auto\n");
  const Model other = make_model(parse_scene(automatic, "docs/scene.md"));
  const auto again = modes(linearise(other, {}, {})).natural_frequencies_hz;
  EXPECT_LE(worst_of(again - frequencies), 1e-9 * frequencies(0)) << again;
  EXPECT_NE(reference().find("20.4 Hz and 128 Hz"), std::string::npos);
  EXPECT_NEAR(frequencies(0), 20.4, 0.05);
  EXPECT_NEAR(frequencies(1), 128, 0.5);
}

}  // namespace
}  // namespace stillframe::test
