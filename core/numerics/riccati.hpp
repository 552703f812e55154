#pragma once

#include <Eigen/Core>

namespace stillframe {

/// x[k+1] = A x[k] + B u[k] at the cost sum of x^T Q x + 2 x^T S u + u^T R u. A: n x n, B and S:
/// n x m (an empty S is zero), Q: n x n and R: m x m symmetric, R positive definite.
struct RiccatiProblem {
  Eigen::MatrixXd A, B, Q, R, S = {};
};

struct RiccatiSolution {
  Eigen::MatrixXd X;    ///< n x n, symmetric: least cost x^T X x from x on
  Eigen::MatrixXd K;    ///< m x n: u = -K x
  double residual = 0;  ///< of the equation, over the sum of the norms of its terms
  double radius = 0;    ///< spectral radius of A - B K, below 1
};

/// The stabilising solution of the discrete algebraic Riccati equation
///   X = A^T X A - (A^T X B + S) (R + B^T X B)^-1 (B^T X A + S^T) + Q,
/// by the structure-preserving doubling algorithm on states scaled alike in A, B R^-1 B^T and Q,
/// then by Newton's steps as long as they lower the residual. The steps needed are those that bring
/// radius^(2^k) to rounding: 60 at most, for what decays by 1e-15 a step. Source: Chu, Fan, Lin and
/// Wang, International Journal of Control 77 (2004) 767-788; Hewer, IEEE Transactions on Automatic
/// Control 16 (1971) 382-384. Set-up, about 15 n^3 flops a step. Errors: std::invalid_argument on
/// shapes or entries that are not finite; Refusal if R is not positive definite, and if no solution
/// is found that stabilises: a mode on or outside the unit circle is not controllable, or the cost
/// does not see one that is on it.
RiccatiSolution solve_riccati(const RiccatiProblem& problem);

}  // namespace stillframe
