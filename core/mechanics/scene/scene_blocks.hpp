#pragma once

#include "core/mechanics/scene/scene_reader.hpp"

namespace stillframe {

/// A scene and its controller block as they are written, before anything of them is checked: what
/// may be changed and read again.
struct SceneBlocks {
  std::string file;  ///< of the scene
  YamlReader scene;
  std::optional<YamlReader> controller;  ///< of a file of its own, named by the scene or beside it
};

/// Errors: InputError of files that are missing, unreadable or no YAML.
SceneBlocks read_scene_blocks(const std::filesystem::path& file,
                              const std::optional<std::filesystem::path>& controller_file);

/// The scene that these are. Errors: as of a file.
Scene scene_of(const SceneBlocks& blocks);

}  // namespace stillframe
