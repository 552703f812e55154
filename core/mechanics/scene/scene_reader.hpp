#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// A block of a scene: written in the scene as a map, or in a file of its own whose path stands in
/// the scene or on the command line. text is the YAML it came from.
struct Block {
  YamlReader reader;
  std::string text;
};

/// Where to look for the files that texts name, if not beside them.
struct NamedFrom {
  std::optional<std::filesystem::path> scene, controller;
};

/// Reads and checks a scene; every name that a key refers to exists and every value is in its
/// range. docs/scene.md is the reference of the keys. controller_file, if given, replaces the
/// scene's controller block. Errors: InputError with file, line, column, key, what was found and
/// what is allowed.
Scene read_scene(const std::filesystem::path& file,
                 const std::optional<std::filesystem::path>& controller_file = std::nullopt,
                 const NamedFrom& named_from = {});

/// The same from text (relative paths are not allowed then), for tests.
Scene parse_scene(const std::string& text, const std::string& source_name);

/// The floor block of the scene, or of floor_file if given; nothing if the scene has none.
std::optional<Block> read_floor(const Scene& scene,
                                const std::optional<std::filesystem::path>& floor_file);

/// FNV-1a, 64 bit, of a text, as 16 hexadecimal digits.
std::string text_hash(const std::string& text);

}  // namespace stillframe
