#include "core/mechanics/scene/disturbances.hpp"

#include <algorithm>

#include "core/mechanics/scene/references.hpp"
#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

namespace {

double read_at(const YamlReader& block) {
  const auto at = block.find("at_s");
  return at ? at->non_negative() : 0.0;
}

ForceStep read_step(const YamlReader& block) {
  block.allow_only({"at_s", "height", "rise_s"});
  const auto rise = block.find("rise_s");
  return {.at_s = read_at(block),
          .height = block.require("height").number(),
          .rise_s = rise ? rise->non_negative() : 0.0};
}

ForceImpact read_impact(const YamlReader& block) {
  block.allow_only({"at_s", "peak", "width_s"});
  return {.at_s = read_at(block),
          .peak = block.require("peak").number(),
          .width_s = block.require("width_s").positive()};
}

ForceSine read_sine(const YamlReader& block) {
  block.allow_only({"at_s", "amplitude", "frequency_hz"});
  return {.at_s = read_at(block),
          .amplitude = block.require("amplitude").positive(),
          .frequency_hz = block.require("frequency_hz").positive()};
}

ForceSweep read_sweep(const YamlReader& block) {
  block.allow_only({"at_s", "amplitude", "from_hz", "to_hz", "sweep_s", "spacing"});
  ForceSweep sweep{.at_s = read_at(block),
                   .amplitude = block.require("amplitude").positive(),
                   .from_hz = block.require("from_hz").positive(),
                   .to_hz = block.require("to_hz").positive(),
                   .sweep_s = block.require("sweep_s").positive()};
  const auto spacing = block.find("spacing");
  sweep.linear = spacing && spacing->one_of({"logarithmic", "linear"}) == "linear";
  return sweep;
}

ForceNoise read_noise(const YamlReader& block) {
  block.allow_only({"at_s", "psd", "seed", "period_s"});
  ForceNoise noise{.at_s = read_at(block), .psd = {}};
  const YamlReader psd = block.require("psd");
  for (const YamlReader& item : psd.items()) {
    const Eigen::VectorXd point = item.vector(2);
    const double last = noise.psd.empty() ? 0.0 : noise.psd.back().first;
    if (!(point(0) > last) || !(point(1) > 0.0)) {
      item.fail("allowed is [frequency, density], both above 0, the frequencies ascending");
    }
    noise.psd.emplace_back(point(0), point(1));
  }
  if (noise.psd.size() < 2) psd.fail("found fewer than two points [frequency, density]");
  if (const auto seed = block.find("seed")) {
    noise.seed = static_cast<std::uint64_t>(seed->integer(0));
  }
  if (const auto period = block.find("period_s")) noise.period_s = period->positive();
  return noise;
}

ForceRecording read_recording(const YamlReader& block) {
  block.allow_only({"at_s", "file", "column", "scale", "start_s"});
  ForceRecording recording{.at_s = read_at(block),
                           .file = block.require("file").text(),
                           .column = block.require("column").text()};
  if (recording.file.is_relative()) {
    recording.file = (block.folder() / recording.file).lexically_normal();
  }
  if (const auto scale = block.find("scale")) recording.scale = scale->number();
  if (const auto start = block.find("start_s")) recording.start_s = start->non_negative();
  return recording;
}

void read_force(const YamlReader& block, SceneDisturbance& disturbance) {
  block.allow_only({"step", "impact", "sine", "sine_sweep", "noise", "recording"});
  const auto kinds = block.entries();
  if (kinds.size() != 1) {
    block.fail("found " + std::to_string(kinds.size()) +
               " kinds of force, allowed is exactly one of step, impact, sine, sine_sweep, noise, "
               "recording");
  }
  const auto& [kind, value] = kinds.front();
  if (kind == "step") {
    disturbance.force = read_step(value);
  } else if (kind == "impact") {
    disturbance.force = read_impact(value);
  } else if (kind == "sine") {
    disturbance.force = read_sine(value);
  } else if (kind == "sine_sweep") {
    disturbance.force = read_sweep(value);
  } else if (kind == "noise") {
    disturbance.force = read_noise(value);
  } else {
    disturbance.force = read_recording(value);
  }
}

/// The text that a file's path stands in, with all of the path.
std::string with_full_path(const YamlReader& file, const std::filesystem::path& path) {
  std::string text =
      file.source_text_with(std::filesystem::absolute(path).lexically_normal().string());
  if (text == file.source_text()) {
    file.fail(
        "a run keeps its scene with all of the path, which cannot be written in the place of this "
        "one; write it without # and escapes, on one line, or from /");
  }
  return text;
}

}  // namespace

std::vector<SceneDisturbance> read_disturbances(const YamlReader& root, const Scene& scene) {
  std::vector<SceneDisturbance> disturbances;
  const auto list = root.find("disturbances");
  if (!list) return disturbances;
  for (const YamlReader& value : list->items()) {
    value.allow_only({"name", "node", "along", "force"});
    SceneDisturbance disturbance;
    disturbance.place = value.place();
    disturbance.name = value.require("name").text();
    disturbance.node = read_node_name(value.require("node"), scene).name;
    disturbance.direction = read_direction(value.require("along"), scene);
    read_force(value.require("force"), disturbance);
    if (std::any_of(disturbances.begin(), disturbances.end(),
                    [&](const auto& other) { return other.name == disturbance.name; })) {
      value.require("name").fail("the name '" + disturbance.name + "' is used twice");
    }
    disturbances.push_back(std::move(disturbance));
  }
  return disturbances;
}

std::string text_with_full_paths(const Scene& scene) {
  std::string text = scene.text;
  for (std::size_t i = 0; i < scene.disturbances.size(); ++i) {
    const auto* recording = std::get_if<ForceRecording>(&scene.disturbances[i].force);
    if (!recording) continue;
    const YamlReader file = YamlReader::from_text(text, scene.file)
                                .require("disturbances")
                                .items()[i]
                                .require("force")
                                .require("recording")
                                .require("file");
    if (!std::filesystem::path(file.text()).is_relative()) continue;
    text = with_full_path(file, recording->file);
  }
  for (const SceneElement& element : scene.elements) {
    if (!element.superelement) continue;
    const YamlReader file = YamlReader::from_text(text, scene.file)
                                .require("elements")
                                .require(element.name)
                                .require("body");
    if (!std::filesystem::path(file.text()).is_relative()) continue;
    text = with_full_path(file, element.superelement->files.front().path);
  }
  return text;
}

}  // namespace stillframe
