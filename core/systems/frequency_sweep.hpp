#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "core/systems/state_space_model.hpp"

namespace stillframe {

/// G(s) of a state space at many frequencies: reduced once to real Schur form, A = S Q T Q^T S^-1,
/// then
///   G(s) = (C (s I - A)^-1 B + D) diag(s^2, s, 1 | s, 1, 1/s | 1, 1/s, 1/s^2 | 1)
/// by the kind of every physical input (position, velocity, acceleration | direct), mixed freely.
/// A frequency costs n^2 m + 2 n m p real multiplications. The poles of T are off by rounding,
/// which matters next to them: where s is that near, the solution is refined on A itself in doubled
/// precision, so that G keeps its accuracy until the pole is met.
/// Source: deck, section 10; THEORY section 2. A: n x n, m physical inputs, p outputs.
class FrequencySweep {
 public:
  /// Set-up, about 25 n^3 flops. Errors: std::invalid_argument for shapes that do not match or
  /// entries that are not finite; Refusal if the Schur form is not found.
  explicit FrequencySweep(const StateSpace& system);

  /// G(s), p x m, s in rad/s. At a pole, and at s = 0 for an input that acts by its integrals, the
  /// entries are not finite. Hot: noexcept, no allocation; not for two threads at once.
  void evaluate(std::complex<double> s, Eigen::Ref<Eigen::MatrixXcd> G) noexcept;

  /// The same without the refinement next to poles, where it is most of the work: off by epsilon
  /// times the norm of A over the distance to the next pole. For bounds, of which three digits do.
  void evaluate_unrefined(std::complex<double> s, Eigen::Ref<Eigen::MatrixXcd> G) noexcept;

  Eigen::Index n_inputs() const { return m_; }
  Eigen::Index n_outputs() const { return p_; }
  const Eigen::VectorXcd& poles() const { return poles_; }

 private:
  using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  /// One column of B and D that acts, of which input, times which power of s.
  struct Term {
    Eigen::Index input, column;
    int power;
  };

  void combine(std::complex<double> s, const RowMatrix& columns, RowMatrix& out) const noexcept;
  void solve_schur(std::complex<double> s, RowMatrix& X) const noexcept;
  bool near_pole(std::complex<double> s) const noexcept;
  void refine(std::complex<double> s) noexcept;
  void residual(std::complex<double> s) noexcept;
  /// G = C X + Y_.
  void read_out(const RowMatrix& C, const RowMatrix& X, Eigen::Ref<Eigen::MatrixXcd> G) noexcept;

  Eigen::Index n_ = 0, m_ = 0, p_ = 0, width_ = 0;
  double norm_ = 0;  ///< of T, 1/s
  std::vector<Term> terms_;
  Eigen::VectorXcd poles_;
  RowMatrix A_, B_, C_, D_;            ///< balanced
  RowMatrix T_, Q_, Q_t_, B_q_, C_q_;  ///< Schur form, Q^T B, C Q
  // Work at one frequency. Complex matrices of m columns are kept as real ones of 2 m (re, im side
  // by side, padded to width_), since T, Q and C are real.
  RowMatrix X_, X_0_, F_, R_, Y_;
};

/// Singular values of G(j omega), largest first: min(p, m) rows, a column a frequency; omega in
/// rad/s. NaN where G is not finite. Errors: as FrequencySweep.
Eigen::MatrixXd singular_values_over(const StateSpace& system, const Eigen::VectorXd& omega);

}  // namespace stillframe
