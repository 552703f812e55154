#include "core/systems/balanced_states.hpp"

#include "core/numerics/balance.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// Writes xi in the order [exogenous plant states | plant states | law | ...], so that the feedback
/// part is one trailing block.
Eigen::PermutationMatrix<Eigen::Dynamic> exogenous_first(Index n, Index n_exogenous, Index total) {
  Eigen::VectorXi target(total);
  for (Index i = 0; i < total; ++i) {
    const Index to = i < n - n_exogenous ? i + n_exogenous : i < n ? i - (n - n_exogenous) : i;
    target(i) = static_cast<int>(to);
  }
  return Eigen::PermutationMatrix<Eigen::Dynamic>(target);
}

}  // namespace

BalancedStates::BalancedStates(const SampledLoop& loop, Index n_plant)
    : P_(exogenous_first(n_plant, loop.n_exogenous, loop.A.rows())),
      S_(balancing_scales(P_ * loop.A * P_.transpose())) {}

SampledLoop BalancedStates::of(SampledLoop loop) const {
  const auto S_inverse = S_.cwiseInverse().asDiagonal();
  loop.A = S_inverse * (P_ * loop.A * P_.transpose()) * S_.asDiagonal();
  loop.B = S_inverse * (P_ * loop.B);
  loop.B_v = S_inverse * (P_ * loop.B_v);
  loop.C = rows(loop.C);
  return loop;
}

}  // namespace stillframe
