#pragma once

#include "core/operating_point.hpp"
#include "tools/json.hpp"

namespace stillframe::tools {

/// "its equilibrium", or "a snapshot of its motion as written".
const char* operating_point_in_words(const Scene& scene);

/// How far each node is from the scene as written: nodes without rotation have none.
struct NodeDisplacement {
  std::string node;
  Eigen::Vector3d displacement;  ///< m
  Eigen::Vector3d rotation;      ///< rad, angle times axis
  bool has_rotation = false;
};
/// x: n_x.
std::vector<NodeDisplacement> node_displacements(const Model& model, const Eigen::VectorXd& x);

/// A list of {node, displacement [m], rotation [rad]}: three numbers each, in a planar scene two
/// and one.
Json to_json(const Model& model, const std::vector<NodeDisplacement>& displacements);
std::string table_of(const Model& model, const std::vector<NodeDisplacement>& displacements);

}  // namespace stillframe::tools
