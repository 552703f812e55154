#pragma once

#include <Eigen/Core>

#include "core/systems/sampled_loop.hpp"

namespace stillframe {

/// Balanced states of a sampled loop, the exogenous ones first, so that the feedback part is one
/// trailing block. Unbalanced, a frame that moves micrometres under forces of newtons has a
/// spectral radius wrong in the second digit. Set-up.
class BalancedStates {
 public:
  /// Of a loop whose first n_plant states are the plant's, of these the last n_exogenous the
  /// floor's.
  BalancedStates(const SampledLoop& loop, Eigen::Index n_plant);

  /// The loop in these states.
  SampledLoop of(SampledLoop loop) const;
  /// Rows that act on the states, in these.
  Eigen::MatrixXd rows(const Eigen::MatrixXd& C) const {
    return C * P_.transpose() * S_.asDiagonal();
  }

 private:
  Eigen::PermutationMatrix<Eigen::Dynamic> P_;
  Eigen::VectorXd S_;
};

}  // namespace stillframe
