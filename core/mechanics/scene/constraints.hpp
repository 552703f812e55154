#pragma once

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// Reads what cannot move, one constraint for each node. Errors: InputError.
void read_supports(const YamlReader& list, Scene& scene);

/// Reads what is moved from outside, one constraint for each node or deformation. Errors:
/// InputError.
void read_prescribed(const YamlReader& list, Scene& scene);

/// Reads constant nodal forces and torques. Errors: InputError.
void read_loads(const YamlReader& list, Scene& scene);

}  // namespace stillframe
