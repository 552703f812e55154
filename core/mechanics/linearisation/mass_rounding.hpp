#pragma once

#include "core/mechanics/kinematics.hpp"

namespace stillframe {

/// What rounding alone may leave on the diagonal of M = X^T M_x X (n), of displacements X (n_x x n)
/// at the positions x: of entries of M_x that are known to eps of the largest of their two parts,
/// and of entries of X that are known to eps of how far their column moves any node. A beam without
/// an inertia about its axis has no mass to its twist; in axes of space that zero is a difference.
Eigen::VectorXd mass_rounding(const Model& model, const Eigen::VectorXd& x, const RowMatrix& X);

}  // namespace stillframe
