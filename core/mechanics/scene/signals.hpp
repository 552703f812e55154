#pragma once

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// Reads the inputs, outputs, monitors and comparisons of a scene whose structure has been read.
/// Errors: InputError.
void read_signals(const YamlReader& root, Scene& scene);

}  // namespace stillframe
