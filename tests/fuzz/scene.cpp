#include "core/errors/input_error.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "tests/fuzz/targets.hpp"

namespace stillframe::fuzz {

namespace {

/// A scene may name files of blocks; these bytes must open none.
bool may_name_files(const std::string& text) {
  return text.find("controller") != std::string::npos && text.find('/') != std::string::npos;
}

}  // namespace

void scene(std::string_view bytes) {
  const std::string text(bytes);
  if (may_name_files(text)) return;
  try {
    const Scene scene = parse_scene(text, "scene");
    // What a reader accepts it accepts again, to the same scene.
    require(parse_scene(scene.text, "scene").hash == scene.hash,
            "a scene that is read twice is one");
  } catch (const InputError&) {
  }
}

}  // namespace stillframe::fuzz
