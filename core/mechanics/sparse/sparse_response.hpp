#pragma once

#include <complex>

#include "core/mechanics/sparse/mixed_factors.hpp"
#include "core/mechanics/sparse/mixed_signals.hpp"

namespace stillframe {

/// G(s), outputs from inputs (n_y x n_u), of a mixed model about a position at rest, by factors of
/// its own at every s: what transfer_function (core/mechanics/frequency_response.hpp) is to a
/// LinearModel. Without damping, and s on either axis, the factors are real.
class SparseResponse {
 public:
  SparseResponse(const MixedModel& mixed, const MixedState& state, MixedSignals signals);

  /// s in rad/s. NaN where the matrix is singular: at a pole of what nothing damps. set-up; not for
  /// two threads at once.
  Eigen::MatrixXcd operator()(std::complex<double> s);

 private:
  template <class Scalar>
  Eigen::MatrixXcd at(std::complex<double> s, MixedFactors<Scalar>& factors) const;

  MixedSignals signals_;
  SparseMatrix E_, M_, D_, G_;
  Eigen::VectorXd compliance_, damping_time_;
  bool damped_;
  MixedFactors<double> real_;
  MixedFactors<std::complex<double>> complex_;
};

}  // namespace stillframe
