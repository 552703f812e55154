#include "core/control/force_feedback.hpp"

#include <Eigen/LU>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/errors/input_error.hpp"

namespace stillframe {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

namespace {

void check_shapes(const ForceFeedback& feedback) {
  const Index m = feedback.K_P.rows();
  for (const MatrixXd* K : {&feedback.K_P, &feedback.K_I}) {
    if (K->rows() != m || K->cols() != m) {
      throw std::invalid_argument("ForceFeedback: expected gains of " + std::to_string(m) + " x " +
                                  std::to_string(m) + ", got " + std::to_string(K->rows()) + " x " +
                                  std::to_string(K->cols()));
    }
  }
}

/// (1 + lead s) corner / (s + corner) on m signals.
LinearSystem low_pass(double corner, double lead, Index m) {
  const MatrixXd I = MatrixXd::Identity(m, m);
  const double direct = lead * corner;
  return {.A = -corner * I, .B = corner * I, .C = (1 - direct) * I, .D = direct * I};
}

/// s / (s + omega) on m signals.
LinearSystem high_pass(double omega, Index m) {
  const MatrixXd I = MatrixXd::Identity(m, m);
  return {.A = -omega * I, .B = I, .C = -omega * I, .D = I};
}

/// The frequencies of leak and high-pass: a high-pass without a leak is a leak, so that no pole at
/// zero is left that nothing moves.
std::pair<double, double> corners(const ForceFeedback& feedback) {
  if (feedback.leak == 0) return {feedback.high_pass, 0.0};
  return {feedback.leak, feedback.high_pass};
}

}  // namespace

MatrixXcd ForceFeedback::operator()(Complex s) const {
  const Index m = K_P.rows();
  const auto [omega_l, omega_h] = corners(*this);
  const Complex pass = omega_h > 0 ? s / (s + omega_h) : Complex(1);
  const MatrixXcd P = (K_P.cast<Complex>() * s + K_I) * (pass / (s + omega_l));
  if (roll_off == 0) return -P;
  const MatrixXcd I = MatrixXcd::Identity(m, m);
  const MatrixXcd F =
      -(I + P).partialPivLu().solve(P) * ((1.0 + lead * s) * roll_off / (s + roll_off));
  return (I + F).partialPivLu().solve(F);
}

LinearSystem strain_feedback(const ForceFeedback& feedback) {
  check_shapes(feedback);
  const Index m = feedback.K_P.rows();
  const MatrixXd I = MatrixXd::Identity(m, m);
  const auto [omega_l, omega_h] = corners(feedback);
  const Eigen::PartialPivLU<MatrixXd> X(I + feedback.K_P);
  if (!(X.rcond() > std::numeric_limits<double>::epsilon())) {
    throw Refusal(
        "K_P: I + K_P is singular, so the feedthrough of the force sensor cannot be "
        "solved for; check the gain design");
  }
  // X u'' + W u' + omega_l omega_h u = -(K_P e'' + K_I e'). With u = D e + v and without a
  // high-pass this is X v' + W v = -(K_I + W D) e; with one, v' = -X^-1 W v + b_1 e + p, p' =
  // -omega_l omega_h X^-1 (v + D e).
  const MatrixXd W = (omega_l + omega_h) * I + feedback.K_I;
  const MatrixXd D = -X.solve(feedback.K_P), A_1 = -X.solve(W);
  const MatrixXd B_1 = -X.solve(feedback.K_I + W * D);
  LinearSystem law{.A = A_1, .B = B_1, .C = I, .D = D};
  if (omega_h > 0) {
    const MatrixXd back = -omega_l * omega_h * X.solve(I);
    law.A.setZero(2 * m, 2 * m);
    law.A << A_1, I, back, MatrixXd::Zero(m, m);
    law.B.resize(2 * m, m);
    law.B << B_1, back * D;
    law.C.resize(m, 2 * m);
    law.C << I, MatrixXd::Zero(m, m);
  }
  if (feedback.roll_off > 0) law = in_series(law, low_pass(feedback.roll_off, feedback.lead, m));
  return law;
}

LinearSystem stress_feedback(const ForceFeedback& feedback) {
  check_shapes(feedback);
  const Index m = feedback.K_P.rows();
  const MatrixXd I = MatrixXd::Identity(m, m);
  const auto [omega_l, omega_h] = corners(feedback);
  LinearSystem law{
      .A = -omega_l * I, .B = I, .C = -(feedback.K_I - omega_l * feedback.K_P), .D = -feedback.K_P};
  if (omega_h > 0) law = in_series(law, high_pass(omega_h, m));
  if (feedback.roll_off > 0) law = in_series(law, low_pass(feedback.roll_off, feedback.lead, m));
  return law;
}

}  // namespace stillframe
