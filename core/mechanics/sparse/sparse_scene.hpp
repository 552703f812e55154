#pragma once

#include <optional>

#include "core/mechanics/model/model.hpp"
#include "core/mechanics/sparse/reduced_model.hpp"

namespace stillframe {

/// The model of a scene for a MixedModel where that way is open and pays: the scene leaves the
/// choice of dofs to the program (`dofs: auto`), nothing of it moves, no load turns with its node,
/// and of its coordinates there are many: beside how many modes or shapes are asked for, and no
/// fewer than `fewest`, where both ways take the same time for these (docs/growth.md).
std::optional<Model> large_scene(const Scene& scene, Eigen::Index n_asked,
                                 Eigen::Index fewest = 200);

/// The reduced model that a scene asks for with `reduce`, of free_model(scene). Errors: InputError
/// at that key where no such model is to be had: the scene moves, asks for a snapshot, or has a
/// load that turns with its node; as sparse_equilibrium and reduced_model.
ReducedModel reduced_model(const Scene& scene, const std::vector<SceneSignal>& inputs,
                           const std::vector<SceneSignal>& outputs);

}  // namespace stillframe
