#pragma once

#include <Eigen/Core>
#include <complex>

#include "core/mechanics/linearisation/linearisation.hpp"

namespace stillframe {

/// The eigenvalues of the state matrix of a linear model, 2 n_d, rad/s: in neighbours sorted by
/// modulus, a conjugate pair, positive imaginary part first, or two real ones. known_to: how far
/// the rounding of the entries of M, C + D and K + N + G can move each, rad/s: to first order, of
/// two that meet to second. It is what tells a zero from a slow motion: stiff springs and strong
/// dampers beside it count only as far as the motion itself strains them.
struct OwnValues {
  Eigen::VectorXcd values;
  Eigen::VectorXd known_to;

  bool is_zero(Eigen::Index i) const { return std::abs(values(i)) <= known_to(i); }
};

/// Errors: as mass_factors and state_matrix; Refusal if they cannot be computed.
OwnValues own_values(const LinearModel& model);

/// M, C + D and K + N + G with what their entries are known to.
class EigenvalueRounding {
 public:
  explicit EigenvalueRounding(const LinearModel& model);
  /// What is unknown of the eigenvalue s with the right and left eigenvectors v and w (n_d each;
  /// (s^2 M + s (C + D) + K + N + G) v = 0, w its transpose's), rad/s. At least epsilon of the
  /// fastest, as directions of elements are known no better.
  double known_to(std::complex<double> s, const Eigen::VectorXcd& v,
                  const Eigen::VectorXcd& w) const;

  const Eigen::MatrixXd M, C, K;                 ///< C = C + D, K = K + N + G of the model
  const Eigen::MatrixXd M_size, C_size, K_size;  ///< of the terms of their entries

 private:
  double fastest_ = 0;  ///< rad/s, of what the dofs alone would be
};

/// Frequencies at which the model moves by itself, Hz, ascending: moduli of its eigenvalues over
/// 2 pi, of a conjugate pair one, without those that are zero. Empty where they are not found.
Eigen::VectorXd own_frequencies_hz(const LinearModel& model);

}  // namespace stillframe
