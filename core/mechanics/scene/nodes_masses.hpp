#pragma once

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// Reads the points of a scene. Errors: InputError.
void read_nodes(const YamlReader& map, Scene& scene);

/// Reads what is heavy, once all nodes are there. Errors: InputError.
void read_masses(const YamlReader& list, Scene& scene);

}  // namespace stillframe
