#pragma once

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// Changes a scene by its `corrections` block, what measurements say that it differs by: relative
/// stiffness and damping of elements, mass and inertia of nodes, displacement of nodes (m),
/// direction of legs (rad, along `across`), delay (samples). What robustness::perturbed does with
/// the same numbers. Structure and controller have been read. Errors: InputError.
void correct(const YamlReader& block, Scene& scene);

}  // namespace stillframe
