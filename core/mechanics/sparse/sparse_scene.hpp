#pragma once

#include <optional>

#include "core/mechanics/model/model.hpp"

namespace stillframe {

/// The model of a scene for a MixedModel where that way is open and pays: the scene leaves the
/// choice of dofs to the program (`dofs: auto`), nothing of it moves, no load turns with its node,
/// and of its coordinates there are many, beside how many modes or shapes are asked for.
std::optional<Model> large_scene(const Scene& scene, Eigen::Index n_asked);

}  // namespace stillframe
