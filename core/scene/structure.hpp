#pragma once

#include "core/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// Reads what the scene is made of: nodes, masses, elements, supports, prescribed motions, dofs and
/// loads. Errors: InputError.
void read_structure(const YamlReader& root, Scene& scene);

/// A direction: x, y, z or three numbers of any length but zero; answers the unit vector.
Eigen::Vector3d read_direction(const YamlReader& value);

/// Fails at `value` if no node (element) has that name, naming the nearest one that exists.
void require_node(const YamlReader& value, const std::string& name, const Scene& scene);
void require_element(const YamlReader& value, const std::string& name, const Scene& scene);

}  // namespace stillframe
