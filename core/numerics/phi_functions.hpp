#pragma once

#include <Eigen/Core>
#include <vector>

namespace stillframe {

/// phi_0(X) ... phi_p(X) of a square matrix (n x n each),
///   phi_0 = exp(X),   phi_k(X) = integral of exp((1 - s) X) s^(k-1) / (k-1)! over s from 0 to 1,
/// by which a linear system goes on under polynomial inputs: with X = tau A
///   integral of exp((tau - s) A) s^k / k! over s from 0 to tau = tau^(k+1) phi_(k+1)(tau A).
/// A Taylor series of X / 2^j, balanced, and j doublings. Set-up. Source: Hochbruck and Ostermann,
/// Acta Numerica 19 (2010) 209-286, section 2.1; Al-Mohy and Higham, SIAM J. Sci. Comput. 33 (2011)
/// 488-511, for the doubling. Errors: std::invalid_argument if X is not square and finite.
std::vector<Eigen::MatrixXd> phi_functions(const Eigen::MatrixXd& X, int p);

/// Integral of exp((tau - s) A) B exp(-rate s) over s from 0 to tau (s): the answer at tau to an
/// input that decays. n x m. Set-up.
Eigen::MatrixXd decay_response(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, double rate,
                               double tau);

}  // namespace stillframe
