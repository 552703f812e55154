#pragma once

#include <string>
#include <vector>

#include "core/mechanics/model/model.hpp"

namespace stillframe {

/// The model of a scene without dofs: every coordinate that is neither fixed nor prescribed is
/// dependent, and nothing is eliminated. What a MixedModel is made of.
Model free_model(const Scene& scene);

/// A free coordinate of a model without dofs, as the dof that it would be.
struct FreeCoordinate {
  Eigen::Index column = 0;
  SceneDof dof;
};
/// All n_c, in the order of the nodes. place: where messages say that they stand.
std::vector<FreeCoordinate> free_coordinates(const Model& model, const std::string& place);

/// Names of the n_c free coordinates, as dofs have them: "x(tip)", "lambda_1(tip)".
std::vector<std::string> coordinate_names(const Model& model);
/// m, of planar rotations rad, of Euler parameters 1.
std::vector<std::string> coordinate_units(const Model& model);

}  // namespace stillframe
