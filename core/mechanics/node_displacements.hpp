#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/mechanics/model/model.hpp"

namespace stillframe {

/// How far each node is from the scene as written: nodes without rotation have none.
struct NodeDisplacement {
  std::string node;
  Eigen::Vector3d displacement;  ///< m
  Eigen::Vector3d rotation;      ///< rad, angle times axis
  bool has_rotation = false;
};
/// x: n_x.
std::vector<NodeDisplacement> node_displacements(const Model& model, const Eigen::VectorXd& x);

}  // namespace stillframe
