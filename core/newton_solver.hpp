#pragma once

#include <Eigen/Core>
#include <functional>

namespace stillframe {

/// Solves f(q) = 0 by KINSOL: full Newton steps, and with a line search if these fail. forces writes f (n) and answers
/// false where it cannot; jacobian answers df/dq (n x n). scale: what counts as a large f; it stops
/// at 1e-10 of it. Writes q, the start on entry; adds to iterations. Answers false if it does not
/// converge. set-up.
bool solve_nonlinear(
    const std::function<bool(const Eigen::VectorXd&, Eigen::VectorXd&)>& forces,
    const std::function<Eigen::MatrixXd(const Eigen::VectorXd&)>& jacobian, double scale,
    Eigen::VectorXd& q, int& iterations);

}  // namespace stillframe
