#include "tools/run/run_files.hpp"

#include "core/files/bytes_of_file.hpp"
#include "core/mechanics/scene/scene_reader.hpp"

namespace stillframe::tools {

namespace {

/// Empty if there is none, and of a pipe, which gives its text only once.
std::string text_of(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return "";
  return bytes_of_file(file).value_or("");
}

}  // namespace

RunFiles::RunFiles(const Scene& scene, const floor::FloorSpec& floor) {
  for (const SceneDisturbance& disturbance : scene.disturbances) {
    const auto* recording = std::get_if<ForceRecording>(&disturbance.force);
    if (recording) add(recording->file, text_of(recording->file));
  }
  if (scene.controller && scene.controller->law) {
    add(scene.controller->law->file, scene.controller->law->bytes);
  }
  for (const SceneElement& element : scene.elements) {
    if (!element.superelement) continue;
    for (const ReadFile& file : element.superelement->files) add(file.path, file.bytes);
  }
  add_recordings(floor);
}

void RunFiles::add_recordings(const floor::FloorSpec& floor) {
  if (const auto* recording = std::get_if<floor::RecordingSpec>(&floor.kind)) {
    add(recording->file, text_of(recording->file));
  } else if (const auto* sum = std::get_if<floor::SumSpec>(&floor.kind)) {
    for (const floor::FloorSpec& part : sum->parts) add_recordings(part);
  }
}

void RunFiles::add(const std::filesystem::path& file, const std::string& text) {
  files_.emplace_back(file, text_hash(text));
}

std::string RunFiles::hash() const {
  std::string hashes;
  for (const auto& [file, hash] : files_) hashes += hash;
  return text_hash(hashes);
}

std::string RunFiles::changed() const {
  for (const auto& [file, hash] : files_) {
    if (text_hash(text_of(file)) != hash) return file.string() + " was changed during the run";
  }
  return "";
}

}  // namespace stillframe::tools
