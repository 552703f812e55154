#pragma once

#include "core/numerics/extended/double_double.hpp"

namespace stillframe {

/// L of L L^T = M in twice the working precision, M a mass matrix, n x n, var. Errors: Refusal if M
/// is not positive definite, or not beyond the rounding of its entries: scaled to a unit diagonal,
/// so that light dofs beside heavy ones and mixed units do no harm, its smallest eigenvalue must be
/// above 10 n eps.
ExtendedMatrix mass_factor(const Eigen::MatrixXd& M);

/// Checks a stiffness matrix, n x n, in the same way. Errors: Refusal.
void require_stiffness(const Eigen::MatrixXd& K);

}  // namespace stillframe
