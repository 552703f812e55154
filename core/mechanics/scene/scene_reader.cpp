#include "core/mechanics/scene/scene_reader.hpp"

#include <algorithm>
#include <cstdint>
#include <system_error>
#include <tuple>

#include "core/errors/formatted.hpp"
#include "core/mechanics/scene/acceptance.hpp"
#include "core/mechanics/scene/controller_block.hpp"
#include "core/mechanics/scene/corrections.hpp"
#include "core/mechanics/scene/scene_blocks.hpp"
#include "core/mechanics/scene/signals.hpp"
#include "core/mechanics/scene/structure.hpp"
#include "core/yaml/instruments_block.hpp"
#include "core/yaml/ranges.hpp"

namespace stillframe {

namespace {

/// A file is read once: a pipe gives its text only once, and another's text might be the second.
Block read_block_file(const std::filesystem::path& path,
                      const std::optional<std::filesystem::path>& named_from = std::nullopt) {
  YamlReader reader = YamlReader::from_file(path);
  if (named_from) reader = YamlReader::from_text(reader.source_text(), path.string(), *named_from);
  return {reader, reader.source_text()};
}

/// A block is written inline as a map, or as the path of a file that holds the map.
Block read_block(const YamlReader& value) {
  if (value.is_map()) return {value, value.dump()};
  const std::filesystem::path path = value.folder() / value.text();
  // A loop of links, say, is neither there nor not.
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    value.fail("the file '" + path.string() + "' " +
               (error ? "cannot be read: " + error.message() : "does not exist"));
  }
  return read_block_file(path);
}

PlantMethod read_method(const YamlReader& value) {
  const std::string name =
      std::apply([&](const auto&... each) { return value.one_of({each.name...}); }, plant_methods);
  return method_named(name).value();
}

SceneSimulation read_simulation(const YamlReader& block) {
  block.allow_only({"duration_s", "relative_tolerance", "method"});
  SceneSimulation simulation;
  simulation.place = block.place();
  if (const auto value = block.find("duration_s")) {
    simulation.duration_s = positive_up_to(*value, 1e9);
  }
  if (const auto value = block.find("relative_tolerance")) {
    simulation.relative_tolerance = number_within(*value, 1e-12, 1e-2);
  }
  if (const auto value = block.find("method")) {
    simulation.method = read_method(*value);
  }
  return simulation;
}

SceneReduction read_reduction(const YamlReader& block) {
  block.allow_only({"modes", "modes_to_hz", "to_hz"});
  SceneReduction reduction;
  reduction.place = block.place();
  const auto modes = block.find("modes"), modes_to = block.find("modes_to_hz"),
             to = block.find("to_hz");
  if (modes && modes_to) modes_to->fail("'modes' says already how many are kept");
  if (!modes && !modes_to && !to) {
    block.fail("nothing says what is kept; write modes, modes_to_hz or to_hz");
  }
  if (modes) reduction.n_modes = integer_within(*modes, 1, 100000);
  if (modes_to) reduction.modes_to_hz = positive_up_to(*modes_to, 1e9);
  if (to) reduction.to_hz = positive_up_to(*to, 1e9);
  return reduction;
}

/// One number, or pairs of a frequency and a number. Nothing if all of them are 0.
std::optional<SceneModalDamping> read_modal_damping(const YamlReader& value) {
  SceneModalDamping damping{.points = {}, .place = value.place() + ": modal_damping"};
  if (!value.is_sequence()) {
    // At 1 a mode does not ring any more; what is meant then is a damper.
    damping.points.push_back({.hz = 0, .ratio = number_within(value, 0, 1)});
  } else {
    for (const YamlReader& item : value.items()) {
      const Eigen::VectorXd pair = item.vector(2);
      const double least = damping.points.empty() ? 0 : damping.points.back().hz;
      const bool rises = damping.points.empty() ? pair(0) >= 0 : pair(0) > least;
      if (!rises || pair(0) > 1e9 || pair(1) < 0 || pair(1) > 1) {
        item.fail(
            formatted("found [%g, %g], allowed are frequencies from 0 to 1e9 Hz that rise, "
                      "and ratios from 0 to 1",
                      pair(0), pair(1)));
      }
      damping.points.push_back({.hz = pair(0), .ratio = pair(1)});
    }
    if (damping.points.empty()) value.fail("found no pair, allowed are one and more");
  }
  const bool none = std::all_of(damping.points.begin(), damping.points.end(),
                                [](const auto& point) { return point.ratio == 0; });
  if (none) return std::nullopt;
  return damping;
}

/// given: a controller block in the place of the scene's.
Scene read_scene_map(const YamlReader& root, const std::string& text,
                     const std::optional<Block>& given) {
  root.allow_only(
      {"title",        "planar",      "gravity",     "operating_point", "nodes",
       "masses",       "elements",    "supports",    "prescribed",      "dofs",
       "loads",        "inputs",      "outputs",     "monitors",        "compare",
       "controller",   "instruments", "uncertainty", "floor",           "simulation",
       "disturbances", "accept",      "reduce",      "corrections",     "modal_damping"});
  Scene scene;
  scene.text = text;
  scene.title = root.require("title").text();
  read_structure(root, scene);
  // Whoever names the scene, on a page, in a table or in JSON, says what its figures are of.
  if (scene.operating_point == OperatingPoint::as_written) scene.title += " (snapshot)";
  scene.hash = text_hash(text + scene.bodies_hash);
  read_signals(root, scene);
  std::optional<Block> controller = given;
  if (!given) {
    if (const auto block = root.find("controller")) controller = read_block(*block);
  }
  if (controller) {
    scene.controller = read_controller(controller->reader, scene);
    // Gains belong to the controller block as much as to the frame.
    scene.hash = text_hash(text + scene.bodies_hash + controller->text +
                           (scene.controller->law ? scene.controller->law->bytes : ""));
  }
  if (const auto block = root.find("corrections")) correct(*block, scene);
  if (const auto block = root.find("instruments")) {
    const int n_legs = scene.controller ? static_cast<int>(scene.controller->legs.size()) : -1;
    scene.instruments = read_scene_instruments(*block, n_legs);
  }
  scene.disturbances = read_disturbances(root, scene);
  if (const auto block = root.find("uncertainty")) scene.uncertainty = read_uncertainty(*block);
  if (const auto block = root.find("simulation")) scene.simulation = read_simulation(*block);
  if (const auto block = root.find("reduce")) scene.reduction = read_reduction(*block);
  if (const auto value = root.find("modal_damping")) {
    scene.modal_damping = read_modal_damping(*value);
    if (scene.modal_damping && scene.reduction) {
      value->fail(
          "a scene that is reduced (`reduce`) has no modal damping; give elements a "
          "damping_time, or leave out one of the two");
    }
  }
  if (const auto block = root.find("accept")) read_acceptance(*block, scene);
  return scene;
}

}  // namespace

Scene read_scene(const std::filesystem::path& file,
                 const std::optional<std::filesystem::path>& controller_file,
                 const NamedFrom& named_from) {
  const auto [root, text] = read_block_file(file, named_from.scene);
  std::optional<Block> controller;
  if (controller_file) controller = read_block_file(*controller_file, named_from.controller);
  Scene scene = read_scene_map(root, text, controller);
  scene.file = file.string();
  return scene;
}

Scene parse_scene(const std::string& text, const std::string& source_name) {
  Scene scene = read_scene_map(YamlReader::from_text(text, source_name), text, std::nullopt);
  scene.file = source_name;
  return scene;
}

SceneBlocks read_scene_blocks(const std::filesystem::path& file,
                              const std::optional<std::filesystem::path>& controller_file) {
  SceneBlocks blocks{file.string(), YamlReader::from_file(file), std::nullopt};
  if (controller_file) {
    blocks.controller = YamlReader::from_file(*controller_file);
  } else if (const auto value = blocks.scene.find("controller"); value && !value->is_map()) {
    blocks.controller = read_block(*value).reader;
  }
  return blocks;
}

Scene scene_of(const SceneBlocks& blocks) {
  std::optional<Block> controller;
  if (blocks.controller) controller = {*blocks.controller, blocks.controller->source_text()};
  Scene scene = read_scene_map(blocks.scene, blocks.scene.source_text(), controller);
  scene.file = blocks.file;
  return scene;
}

std::optional<Block> read_floor(const Scene& scene,
                                const std::optional<std::filesystem::path>& floor_file) {
  if (floor_file) return read_block_file(*floor_file);
  const auto folder = std::filesystem::path(scene.file).parent_path();
  const auto value =
      YamlReader::from_text(scene.text, scene.file, folder.empty() ? "." : folder).find("floor");
  if (!value) return std::nullopt;
  return read_block(*value);
}

std::string text_hash(const std::string& text) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const unsigned char byte : text) hash = (hash ^ byte) * 1099511628211ULL;
  return formatted("%016llx", static_cast<unsigned long long>(hash));
}

}  // namespace stillframe
