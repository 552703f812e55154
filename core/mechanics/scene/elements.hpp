#pragma once

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// Reads what joins the nodes; a divided beam adds its parts and the nodes between them. Errors:
/// InputError.
void read_elements(const YamlReader& map, Scene& scene);

}  // namespace stillframe
