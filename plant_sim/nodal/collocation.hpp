#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

namespace stillframe::nodal {

/// The Radau IIA method of s stages, order 2 s - 1 (E. Hairer, G. Wanner, Solving ordinary
/// differential equations II, sections IV.5 and IV.8), s odd.
struct Collocation {
  /// set-up. Errors: std::invalid_argument if s is even or below 1.
  explicit Collocation(Eigen::Index stages);

  Eigen::VectorXd c;       ///< s, instants of the stages; the last is 1
  Eigen::MatrixXd A, A_2;  ///< s x s, and its square; the last row are the weights
  /// Differences d (s) to the weights of an embedded formula of order s, which has the weight gamma
  /// at the beginning beside, and d A.
  Eigen::VectorXd d, d_A;
  double gamma = 0;  ///< real eigenvalue of A
  /// A = T diag(mu) T^-1: column (s) and row (s) of gamma, and of one of each conjugate pair mu.
  Eigen::VectorXd T_real;
  Eigen::RowVectorXd T_inverse_real;
  std::vector<std::complex<double>> mu;
  Eigen::MatrixXcd T, T_inverse;  ///< s x pairs, pairs x s

  /// Writes the weights (s) that extrapolate the polynomial through values at the stages of a step
  /// of length 1 to an instant t. hot.
  void extrapolate(double t,
                   Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> weights) const noexcept;

  Eigen::MatrixXd coefficients;  ///< s x s, of that polynomial from the values
};

}  // namespace stillframe::nodal
