#pragma once

#include "core/mechanics/model/model.hpp"

namespace stillframe {

/// Writes model.modal_dampers, P: what damps each natural mode of the scene's operating point by
/// the ratio that `modal_damping` of the scene gives its frequency, besides what elements damp.
/// With the elastic part A = (E V)^T S E V of the stiffness on the mass-normalised modes V, where E
/// = DF^(e), and Omega their natural frequencies, P = S E V A^-1 (2 zeta Omega)^(1/2), so that V^T
/// E^T P P^T E V = 2 zeta Omega. It resists deformations alone, so no rigid motion of what the
/// frame stands on, and takes energy from any. Modes are those of the symmetric half of the
/// stiffness, without gyroscopic terms. Errors: Refusal, naming the key, if a dof moves no mass, or
/// a mode that has a ratio is held by weight or loads and not by deformations.
void add_modal_damping(const Scene& scene, Model& model);

}  // namespace stillframe
