#pragma once

#include <Eigen/Core>

namespace stillframe {

/// The diagonal S, powers of two, for which every row of S^-1 A S has about the norm of its column
/// (n entries). The change is exact, and takes away the rounding errors that states of units orders
/// of magnitude apart (micrometres beside newtons) bring into eigenvalues and solutions. A: n x n.
/// Source: Parlett and Reinsch, Numerische Mathematik 13 (1969) 293-304.
Eigen::VectorXd balancing_scales(Eigen::MatrixXd A);

/// S^-1 A S with those scales.
Eigen::MatrixXd balanced(const Eigen::MatrixXd& A);

}  // namespace stillframe
