#pragma once

#include "core/mechanics/scene/scene.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

/// Reads the section, masses and rigid deformations of a beam whose ends p and q (positions, m) are
/// known. Errors: InputError.
void read_beam(const YamlReader& value, const Scene& scene, const Eigen::Vector3d& p,
               const Eigen::Vector3d& q, SceneElement& element);

}  // namespace stillframe
