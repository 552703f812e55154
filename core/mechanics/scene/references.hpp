#pragma once

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

// How one part of a scene refers to another, and the vectors that all parts share.
namespace stillframe {

/// The node of which `value` is the name. Errors: there is none; the nearest name is told.
const SceneNode& read_node_name(const YamlReader& value, const Scene& scene);

/// The element of which `value` is the name. Errors: there is none, or it is a divided beam and one
/// of its parts has to be named.
const SceneElement& read_element_name(const YamlReader& value, const Scene& scene);

/// The element of that name, or all parts of the divided beam of that name.
std::vector<const SceneElement*> read_element_parts(const YamlReader& value, const Scene& scene);

/// Key `mode` of a map, from 1 to the number of deformations; without it `otherwise`, and 0 makes
/// it required where a bare name does not say which deformation is meant (beams).
int read_mode(const YamlReader& map, const SceneElement& element, int otherwise);

/// Three numbers; in a planar scene two, or three of which the last is 0.
Eigen::Vector3d read_vector(const YamlReader& value, const Scene& scene);

/// How far a coordinate is moved from the scene as written (m, rad): up to 1e4 either way. The way
/// there is followed in steps of a third of a radian, so that what turns beside it counts its
/// turns.
double read_displacement(const YamlReader& value);

/// A direction: x, y, z or a vector of any length but zero, in a planar scene without z; answers
/// the unit vector.
Eigen::Vector3d read_direction(const YamlReader& value, const Scene& scene);

/// Fails if the name of a node or an element has a '/', which names the parts of a divided beam.
void refuse_slash(const YamlReader& value, const std::string& name);

/// A number as messages show it.
std::string shown(double number);

}  // namespace stillframe
