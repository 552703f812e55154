#pragma once

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// A superelement: its nodes are the interfaces of the body in their order, and how they stand to
/// each other in the scene says how the body is turned and where it is. Adds the nodes that its
/// modes' amplitudes are the translations of. Errors: InputError.
void read_superelement(const YamlReader& value, SceneElement& element, Scene& scene);

}  // namespace stillframe
