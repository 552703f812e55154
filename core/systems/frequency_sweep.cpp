#include "core/systems/frequency_sweep.hpp"

#include <cmath>
#include <stdexcept>

#include "core/errors/input_error.hpp"
#include "core/numerics/balance.hpp"
#include "core/numerics/eigenvalues.hpp"
#include "core/numerics/infinity.hpp"
#include "core/numerics/row_sums.hpp"
#include "core/numerics/singular_values.hpp"

namespace stillframe {

namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXd;
using Kind = InputColumns::Kind;

/// Nearer to a pole than this part of the norm of T, a solution is refined. The error without is
/// about epsilon times the inverse of it.
constexpr double near_part = 1e-3;

/// s^power without the overflow that s^2 has long before s^-2 does.
Complex power_of(Complex s, int power) noexcept {
  switch (power) {
    case 2:
      return s * s;
    case 1:
      return s;
    case -1:
      return 1.0 / s;
    case -2:
      return 1.0 / s / s;
    default:
      return 1.0;
  }
}

int highest_power(Kind kind) { return kind == Kind::position ? 2 : kind == Kind::velocity ? 1 : 0; }

Eigen::VectorXcd poles_of(const MatrixXd& T) {
  Eigen::VectorXcd poles(T.rows());
  for (Index i = 0; i < T.rows(); ++i) {
    if (i + 1 == T.rows() || T(i + 1, i) == 0.0) {
      poles(i) = T(i, i);
      continue;
    }
    const double half_difference = (T(i, i) - T(i + 1, i + 1)) / 2;
    const double squared = half_difference * half_difference + T(i, i + 1) * T(i + 1, i);
    const Complex root = std::sqrt(Complex(squared));
    poles(i) = T(i + 1, i + 1) + half_difference + root;
    poles(i + 1) = T(i + 1, i + 1) + half_difference - root;
    ++i;
  }
  return poles;
}

/// (s I - T) X = X for two rows, by elimination with a pivot. Cramer's rule would do but next to
/// coinciding poles, where its residual is amplified twice.
void solve_block(Complex s, const Eigen::Matrix2d& T, Complex* first, Complex* second,
                 Index m) noexcept {
  Complex a = s - T(0, 0), b = -T(0, 1), c = -T(1, 0), d = s - T(1, 1);
  const bool swapped = std::norm(c) > std::norm(a);
  if (swapped) {
    std::swap(a, c);
    std::swap(b, d);
    std::swap(first, second);
  }
  const Complex inverse_a = 1.0 / a, ratio = c * inverse_a, inverse_d = 1.0 / (d - ratio * b);
  for (Index j = 0; j < m; ++j) {
    const Complex x_2 = inverse_d * (second[j] - ratio * first[j]);
    const Complex x_1 = inverse_a * (first[j] - b * x_2);
    (swapped ? second : first)[j] = x_1;
    (swapped ? first : second)[j] = x_2;
  }
}

}  // namespace

FrequencySweep::FrequencySweep(const StateSpace& system)
    : n_(system.A.rows()),
      m_(static_cast<Index>(system.columns.size())),
      p_(system.C.rows()),
      width_((2 * m_ + row_chunk - 1) / row_chunk * row_chunk) {
  check_shapes(system);
  if (!system.A.allFinite() || !system.B.allFinite() || !system.C.allFinite() ||
      !system.D.allFinite()) {
    throw std::invalid_argument("frequency sweep: a matrix has an entry that is not finite");
  }
  for (Index j = 0; j < m_; ++j) {
    const InputColumns& input = system.columns[static_cast<size_t>(j)];
    for (Index i = 0; i < input.width(); ++i) {
      const Index column = input.first + i;
      if (system.B.col(column).isZero(0) && system.D.col(column).isZero(0)) continue;
      terms_.push_back({j, column, highest_power(input.kind) - static_cast<int>(i)});
    }
  }
  const Eigen::VectorXd S = balancing_scales(system.A);
  A_ = S.cwiseInverse().asDiagonal() * system.A * S.asDiagonal();
  B_ = S.cwiseInverse().asDiagonal() * system.B;
  C_ = system.C * S.asDiagonal();
  D_ = system.D;
  const auto schur = real_schur_form(A_);
  if (!schur) {
    throw Refusal(
        "the frequency response cannot be computed: the Schur form of the state matrix is not "
        "found, or its entries are too far apart; look for a stiffness, mass or damping with a "
        "wrong power of ten");
  }
  T_ = schur->T;
  Q_ = schur->Q;
  poles_ = poles_of(T_);
  norm_ = T_.norm();
  B_q_ = Q_.transpose() * B_;
  C_q_ = C_ * Q_;
  Q_t_ = Q_.transpose();
  for (RowMatrix* work : {&X_, &X_0_, &F_, &R_}) work->setZero(n_, width_);
  Y_.setZero(p_, width_);
}

void FrequencySweep::combine(Complex s, const RowMatrix& columns, RowMatrix& out) const noexcept {
  out.setZero();
  for (const Term& term : terms_) {
    const Complex factor = power_of(s, term.power);
    for (Index i = 0; i < columns.rows(); ++i) {
      out(i, 2 * term.input) += factor.real() * columns(i, term.column);
      out(i, 2 * term.input + 1) += factor.imag() * columns(i, term.column);
    }
  }
}

void FrequencySweep::solve_schur(Complex s, RowMatrix& X) const noexcept {
  const auto entry = [&](Index i, Index j) -> Complex& {
    return reinterpret_cast<Complex*>(X.data() + i * width_)[j];
  };
  for (Index end = n_; end > 0;) {
    const bool block = end > 1 && T_(end - 1, end - 2) != 0.0;
    const Index i = block ? end - 2 : end - 1;
    for (Index row = i; row < end; ++row) {
      add_combination(&T_(row, 0) + end, X.data() + end * width_, n_ - end, width_,
                      X.data() + row * width_);
    }
    if (block) {
      solve_block(s, T_.block<2, 2>(i, i), &entry(i, 0), &entry(i + 1, 0), m_);
    } else {
      const Complex inverse = 1.0 / (s - T_(i, i));
      for (Index j = 0; j < m_; ++j) entry(i, j) *= inverse;
    }
    end = i;
  }
}

bool FrequencySweep::near_pole(Complex s) const noexcept {
  const double limit = near_part * norm_;
  return (poles_.array() - s).abs2().minCoeff() < limit * limit;
}

/// R = F - (s I - A) X_0, every sum in doubled precision.
void FrequencySweep::residual(Complex s) noexcept {
  doubled_residual(s, n_, width_, 2 * m_, A_.data(), X_0_.data(), F_.data(), R_.data());
}

/// Improves X_0, a solution of (s I - A) X_0 = F, until it stands still.
void FrequencySweep::refine(Complex s) noexcept {
  double last = infinity, first = 1;
  for (int step = 0; step < 10; ++step) {
    residual(s);
    X_.setZero();
    for (Index i = 0; i < n_; ++i) {
      add_combination(&Q_t_(i, 0), R_.data(), n_, width_, X_.data() + i * width_);
    }
    solve_schur(s, X_);
    R_.setZero();
    for (Index i = 0; i < n_; ++i) {
      add_combination(&Q_(i, 0), X_.data(), n_, width_, R_.data() + i * width_);
    }
    const double change = R_.squaredNorm() / X_0_.squaredNorm();
    if (!(change < last)) return;
    X_0_ += R_;
    last = change / 4;
    // Every change is smaller than the one before by about the first: would the next be rounding?
    if (step == 0) first = change;
    if (change * first < 1e-33) return;
  }
}

void FrequencySweep::evaluate(Complex s, Eigen::Ref<Eigen::MatrixXcd> G) noexcept {
  if (n_ == 0 || !near_pole(s)) {
    evaluate_unrefined(s, G);
    return;
  }
  combine(s, D_, Y_);
  combine(s, B_q_, X_);
  solve_schur(s, X_);
  combine(s, B_, F_);
  X_0_.setZero();
  for (Index i = 0; i < n_; ++i) {
    add_combination(&Q_(i, 0), X_.data(), n_, width_, X_0_.data() + i * width_);
  }
  refine(s);
  read_out(C_, X_0_, G);
}

void FrequencySweep::evaluate_unrefined(Complex s, Eigen::Ref<Eigen::MatrixXcd> G) noexcept {
  combine(s, D_, Y_);
  combine(s, B_q_, X_);
  solve_schur(s, X_);
  read_out(C_q_, X_, G);
}

void FrequencySweep::read_out(const RowMatrix& C, const RowMatrix& X,
                              Eigen::Ref<Eigen::MatrixXcd> G) noexcept {
  for (Index i = 0; i < p_; ++i) {
    double* row = Y_.data() + i * width_;
    add_combination(C.data() + i * n_, X.data(), n_, width_, row);
    for (Index j = 0; j < m_; ++j) G(i, j) = {row[2 * j], row[2 * j + 1]};
  }
}

Eigen::MatrixXd singular_values_over(const StateSpace& system, const Eigen::VectorXd& omega) {
  FrequencySweep sweep(system);
  const Index p = sweep.n_outputs(), m = sweep.n_inputs();
  SingularValues singular_values(p, m);
  std::vector<Eigen::MatrixXcd> G(lanes, Eigen::MatrixXcd(p, m));
  Eigen::MatrixXd values(std::min(p, m), omega.size());
  for (Index begin = 0; begin < omega.size(); begin += lanes) {
    const Index count = std::min(lanes, omega.size() - begin);
    for (Index i = 0; i < count; ++i) {
      sweep.evaluate({0.0, omega(begin + i)}, G[static_cast<size_t>(i)]);
    }
    singular_values.compute(G.data(), count, values.middleCols(begin, count));
  }
  return values;
}

}  // namespace stillframe
