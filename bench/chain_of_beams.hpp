#pragma once

#include <string>

#include "core/mechanics/scene/scene_reader.hpp"

namespace stillframe {

/// A flexible cantilever in space of n beams: 6 n dofs, nodal coordinates or deformations.
inline Scene chain_of_beams(int n, bool by_deformations) {
  const std::string text = R"(title: Chain of beams
nodes:
  root: {position: [0, 0, 0]}
  tip: {position: [1, 0, 0]}
masses: []
elements:
  beam: {type: beam, nodes: [root, tip], orientation: y, EA: 1e4, GJ: 1, EI_y: 1, EI_z: 4,
    mass_per_length: 1, inertia_per_length: 0.01, divide: )" +
                           std::to_string(n) + R"(}
supports:
  - {nodes: [root], fix: [x, y, z, rotation]}
inputs:
  - {name: push, force: tip, along: z}
outputs:
  - {name: answer, acceleration: tip, along: z}
dofs: )" + (by_deformations ? "[{deformations: beam}]" : "auto") +
                           "\n";
  return parse_scene(text, "chain of beams");
}

}  // namespace stillframe
