#pragma once

#include <Eigen/Core>

namespace stillframe::controller {

/// The matrix S^-1 A S with a diagonal S of powers of two, which brings every row and its column to
/// about one norm.
/// It has exactly the eigenvalues of A, and much smaller rounding errors in computing them where
/// the states of A differ in unit by orders of magnitude (metres beside newtons). Source: Parlett
/// and Reinsch, Numerische Mathematik 13 (1969) 293-304. A: n x n. Set-up.
Eigen::MatrixXd balanced(Eigen::MatrixXd A);

}  // namespace stillframe::controller
