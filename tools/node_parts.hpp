#pragma once

#include <Eigen/SparseCore>

#include "core/mechanics/model/model.hpp"

namespace stillframe::tools {

/// What moves the nodes that bear mass; the others go along with them.
struct NodeParts {
  std::vector<std::string> names;                ///< n: "table x" (m), "table ry" (rad)
  Eigen::SparseMatrix<double> of_displacements;  ///< n x n_x
};
/// x: n_x, nodal displacements of the operating point.
NodeParts node_parts(const Model& model, const Eigen::VectorXd& x);

/// DF (n_x x n_d) there: the displacements of a unit of each dof.
Eigen::MatrixXd displacements_of_dofs(const Model& model, const Eigen::VectorXd& x);

}  // namespace stillframe::tools
