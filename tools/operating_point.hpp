#pragma once

#include "core/mechanics/node_displacements.hpp"
#include "core/mechanics/operating_point.hpp"
#include "tools/json.hpp"

namespace stillframe::tools {

/// "its equilibrium", or "a snapshot of its motion as written".
const char* operating_point_in_words(const Scene& scene);

/// A list of {node, displacement [m], rotation [rad]}: three numbers each, in a planar scene two
/// and one.
Json to_json(const Model& model, const std::vector<NodeDisplacement>& displacements);
std::string table_of(const Model& model, const std::vector<NodeDisplacement>& displacements);

}  // namespace stillframe::tools
