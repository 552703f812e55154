#include "controller/law.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "controller/tustin.hpp"
#include "core/yaml/input_error.hpp"

namespace stillframe::controller {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

namespace {

constexpr double two_pi = 2 * std::numbers::pi;
constexpr std::int64_t longest_gap = 100;

// X du/dt + W u = -(K_P de/dt + K_I e) with W = w_l I + K_I; with u = v - X^-1 K_P e the derivative
// of e drops out, and m states v are enough.
StateSpace implicit_feedthrough(const Gains& gains) {
  const Index m = gains.n_legs();
  const MatrixXd I = MatrixXd::Identity(m, m);
  const Eigen::PartialPivLU<MatrixXd> X(I + gains.K_P);
  if (!(X.rcond() > std::numeric_limits<double>::epsilon())) {
    throw Refusal(
        "K_P: I + K_P is singular, so the feedthrough of the force sensor cannot be "
        "solved for; check the gain design");
  }
  const MatrixXd W = two_pi * gains.leak_hz * I + gains.K_I;
  const MatrixXd D = -X.solve(gains.K_P);
  return {.A = -X.solve(W), .B = -X.solve(gains.K_I + W * D), .C = I, .D = D};
}

StateSpace naive_pi(const Gains& gains) {
  const Index m = gains.n_legs();
  const MatrixXd I = MatrixXd::Identity(m, m);
  return {.A = -two_pi * gains.leak_hz * I, .B = I, .C = -gains.K_I, .D = -gains.K_P};
}

StateSpace low_pass(double corner_hz, Index m) {
  const MatrixXd I = MatrixXd::Identity(m, m);
  const double w_r = two_pi * corner_hz;
  return {.A = -w_r * I, .B = w_r * I, .C = I, .D = MatrixXd::Zero(m, m)};
}

// Linear prediction from two samples, (1 + a) e[k] - a e[k-1]: what e will be a samples later, up
// to its curvature.
StateSpace lead(double samples, Index m) {
  const MatrixXd I = MatrixXd::Identity(m, m);
  return {.A = MatrixXd::Zero(m, m), .B = I, .C = -samples * I, .D = (1 + samples) * I};
}

void check_shapes(const Gains& gains) {
  const Index m = gains.n_legs();
  for (const MatrixXd* K : {&gains.K_P, &gains.K_I}) {
    if (K->rows() != m || K->cols() != m) {
      throw std::invalid_argument("law_from_gains: expected gains of " + std::to_string(m) + " x " +
                                  std::to_string(m) + ", got " + std::to_string(K->rows()) + " x " +
                                  std::to_string(K->cols()));
    }
  }
}

}  // namespace

DiscreteLaw law_from_gains(const Gains& gains) {
  check_shapes(gains);
  const bool implicit = gains.realisation == Realisation::implicit_feedthrough;
  const double T = gains.sample_time();
  StateSpace law = tustin(implicit ? implicit_feedthrough(gains) : naive_pi(gains), T);
  if (gains.lead_samples > 0) law = in_series(lead(gains.lead_samples, gains.n_legs()), law);
  if (gains.roll_off_hz) {
    law = in_series(law, tustin(low_pass(*gains.roll_off_hz, gains.n_legs()), T));
  }
  return {.A = law.A, .B = law.B, .C = law.C, .D = law.D, .subtract_applied = implicit};
}

Law::Law(DiscreteLaw matrices) : matrices_(std::move(matrices)) {
  const Index n = matrices_.A.rows(), m = matrices_.D.rows();
  const bool fits = matrices_.A.cols() == n && matrices_.B.rows() == n && matrices_.B.cols() == m &&
                    matrices_.C.rows() == m && matrices_.C.cols() == n && matrices_.D.cols() == m;
  if (!fits) throw std::invalid_argument("Law: the matrices are not those of one law");
  x_ = VectorXd::Zero(n);
  x_next_ = VectorXd::Zero(n);
  e_ = e_now_ = e_last_ = VectorXd::Zero(m);
}

void Law::advance() noexcept {
  x_next_.noalias() = matrices_.A * x_;
  x_next_.noalias() += matrices_.B * e_;
  x_.swap(x_next_);
}

void Law::step(const Ref<const VectorXd>& sigma, const Ref<const VectorXd>& applied,
               Ref<VectorXd> force) noexcept {
  step_over(1, sigma, applied, force);
}

void Law::step_over(std::int64_t n_samples, const Ref<const VectorXd>& sigma,
                    const Ref<const VectorXd>& applied, Ref<VectorXd> force) noexcept {
  e_now_ = sigma;
  if (matrices_.subtract_applied) e_now_ -= applied;
  const std::int64_t n = std::clamp<std::int64_t>(n_samples, 1, longest_gap);
  for (std::int64_t j = 1; j < n; ++j) {
    const double part = static_cast<double>(j) / static_cast<double>(n);
    e_ = e_last_ + part * (e_now_ - e_last_);
    advance();
  }
  e_ = e_now_;
  force.noalias() = matrices_.C * x_;
  force.noalias() += matrices_.D * e_;
  advance();
  e_last_ = e_now_;
}

}  // namespace stillframe::controller
