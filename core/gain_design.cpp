#include "core/gain_design.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "core/yaml/input_error.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;

LegMatrices leg_matrices(const MatrixXd& M_dd, const MatrixXd& K_dd, const MatrixXd& E) {
  if (E.rows() != E.cols()) {
    throw Refusal("the decoupled design needs as many legs as dofs: " + std::to_string(E.rows()) +
                  " legs, " + std::to_string(E.cols()) + " dofs");
  }
  if (E.isIdentity(0)) return {M_dd, K_dd};
  const Eigen::FullPivLU<MatrixXd> lu(E);
  if (!lu.isInvertible()) {
    throw Refusal("the legs do not determine the motion of the frame: " +
                  std::to_string(E.cols() - lu.rank()) + " motion(s) strain none of them");
  }
  const MatrixXd inverse = lu.inverse();
  return {inverse.transpose() * M_dd * inverse, inverse.transpose() * K_dd * inverse};
}

Eigen::MatrixXcd ForceFeedback::operator()(std::complex<double> s) const {
  return -(K_P.cast<std::complex<double>>() * s + K_I) / (s + leak);
}

ForceFeedback design_gains(const LegMatrices& legs, double omega_d, double zeta, GainOrder order,
                           double leak) {
  const Index m = legs.M.rows();
  const Eigen::LLT<MatrixXd> M(legs.M);
  if (M.info() != Eigen::Success) {
    throw Refusal("the mass matrix is not positive definite: the legs move a dof without mass");
  }
  // K M^-1 = (M^-1 K)^T as both matrices are symmetric.
  const MatrixXd M_inverse_K = M.solve(legs.K);
  const MatrixXd X = (order == GainOrder::deck ? M_inverse_K : MatrixXd(M_inverse_K.transpose())) /
                     (omega_d * omega_d);
  return {.K_P = X - MatrixXd::Identity(m, m), .K_I = 2 * zeta * omega_d * X, .leak = leak};
}

Eigen::VectorXcd closed_loop_poles(const LegMatrices& legs, const ForceFeedback& gains,
                                   double omega_scale) {
  const Index m = legs.M.rows();
  const MatrixXd I = MatrixXd::Identity(m, m);
  const MatrixXd K_M_inverse = Eigen::LLT<MatrixXd>(legs.M).solve(legs.K).transpose();
  const Eigen::PartialPivLU<MatrixXd> X(gains.K_P + I);
  MatrixXd A = MatrixXd::Zero(3 * m, 3 * m);
  A.block(0, m, m, m) = omega_scale * I;
  A.block(m, 0, m, m) = -K_M_inverse / omega_scale;
  A.block(m, 2 * m, m, m) = -K_M_inverse / omega_scale;
  A.block(2 * m, 0, m, m) = -X.solve(gains.K_I);
  A.block(2 * m, m, m, m) = -omega_scale * X.solve(gains.K_P);
  A.block(2 * m, 2 * m, m, m) = -X.solve(gains.K_I + gains.leak * I);
  return A.eigenvalues();
}

}  // namespace stillframe
