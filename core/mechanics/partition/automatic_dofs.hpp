#pragma once

#include <vector>

#include "core/mechanics/model/model.hpp"

namespace stillframe {

/// Nodal coordinates that can be the dofs of a scene: of all coordinates that are neither fixed nor
/// prescribed, those that are left when the conditions (zero and prescribed deformations, norms of
/// Euler parameters) have taken the best dependent ones, by QR factorisation with column pivoting.
/// Errors: InputError if the conditions are not independent.
std::vector<SceneDof> automatic_dofs(const Scene& scene);

}  // namespace stillframe
