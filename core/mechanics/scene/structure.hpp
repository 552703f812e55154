#pragma once

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// Reads what the scene is made of and where it is looked at: nodes, masses, elements, supports,
/// prescribed motions, dofs, loads, gravity and operating point. Errors: InputError.
void read_structure(const YamlReader& root, Scene& scene);

}  // namespace stillframe
