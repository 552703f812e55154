#pragma once

#include "core/mechanics/model/model.hpp"

namespace stillframe::tools {

/// What a motion of the dofs does to the nodes that bear mass; the others go along with them.
struct NodeParts {
  std::vector<std::string> names;  ///< n: "table x" (m), "table ry" (rad)
  Eigen::MatrixXd of_dofs;         ///< n x n_d, 1 of each dof
};

/// x: n_x, nodal displacements of the operating point.
NodeParts node_parts(const Model& model, const Eigen::VectorXd& x);

}  // namespace stillframe::tools
