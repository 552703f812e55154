#pragma once

#include "core/mechanics/scene/scene.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe {

struct Model;

/// The plant of a scene's loop with forces on the frame in place of the floor: w are forces (N) at
/// the places and along the directions of the scene's outputs, y the displacements there (m), so
/// that open_loop and close_loop of it tell what forces on the frame do. About the scene's
/// equilibrium. Errors: as require_loop_signals and the equilibrium.
LoopPlant compliance_plant(const Scene& scene, const Model& model);

}  // namespace stillframe
