#pragma once

#include <vector>

#include "core/mechanics/model/model.hpp"

namespace stillframe {

/// A free coordinate of a model without dofs, as the dof that it would be.
struct FreeCoordinate {
  Eigen::Index column = 0;
  SceneDof dof;
};
/// All n_c, in the order of the nodes.
std::vector<FreeCoordinate> free_coordinates(const Model& model, const std::string& place);

/// Nodal coordinates that can be the dofs of a scene: of all coordinates that are neither fixed nor
/// prescribed, those that are left when the conditions (zero and prescribed deformations, norms of
/// Euler parameters) have taken the best dependent ones, by QR factorisation with column pivoting.
/// Errors: InputError if the conditions are not independent.
std::vector<SceneDof> automatic_dofs(const Scene& scene);

}  // namespace stillframe
