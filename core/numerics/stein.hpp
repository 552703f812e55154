#pragma once

#include <Eigen/Core>

namespace stillframe {

/// X = A^T X A + Q, the sum of (A^T)^k Q A^k, by doubling; A: n x n with a spectral radius below 1,
/// Q: n x n. Source: Smith, SIAM Journal on Applied Mathematics 16 (1968) 198-201. Set-up. Not
/// finite where A is not stable.
Eigen::MatrixXd solve_stein(Eigen::MatrixXd A, const Eigen::MatrixXd& Q);

}  // namespace stillframe
