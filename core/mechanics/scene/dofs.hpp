#pragma once

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// Reads what is free: the word auto, or a sequence of dofs. Errors: InputError.
void read_dofs(const YamlReader& value, Scene& scene);

}  // namespace stillframe
