#pragma once

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

// The keys that say something of each deformation of an element.
namespace stillframe {

/// Gives an element n deformations, none rigid, without stiffness, damping and preload.
void set_deformations(SceneElement& element, Eigen::Index n);

/// Key `rigid` of an element: a list of the numbers of deformations, or true (all) or false (none).
std::vector<bool> read_rigid(const YamlReader& value, const SceneElement& element);

/// Key `stiffness` or `damping` of an element whose rigid deformations are known: n_e rows of n_e
/// numbers, symmetric and positive semidefinite; n_e numbers, its diagonal; or one number if one
/// deformation is not rigid. `what` names the matrix in messages.
Eigen::MatrixXd read_symmetric(const YamlReader& value, const SceneElement& element,
                               const std::string& what);

/// Key `preload` of such an element: n_e numbers, or one if one deformation is not rigid.
Eigen::VectorXd read_preload(const YamlReader& value, const SceneElement& element);

}  // namespace stillframe
