#pragma once

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// Reads a controller block for a scene whose structure has been read. Errors: InputError.
SceneController read_controller(const YamlReader& block, const Scene& scene);

/// Reads an uncertainty block. Errors: InputError.
SceneUncertainty read_uncertainty(const YamlReader& block);

}  // namespace stillframe
