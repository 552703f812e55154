#pragma once

#include <vector>

#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/mechanics/sparse/mixed_model.hpp"

namespace stillframe {

/// What n_u inputs do to a mixed model about a position at rest, and what n_y outputs see of it:
///   -c s + E x = e w,
///   E^T s + G x + D x' + M x'' = F u - K_w w - D_w w' - M_w w'',
///   y = S s + Y_p x + Y_v x' + Y_a x'' + R_p w + R_v w' + R_a w'' + D_u u.
/// A force, torque or driving stress is u, a prescribed motion w, w' or w'' by its quantity, as of
/// LinearModel; columns that do not apply are zero. The rates of a damping_time are in s.
struct MixedSignals {
  std::vector<SignalInfo> inputs, outputs;
  Eigen::MatrixXd e;                   ///< n_rows x n_u
  Eigen::MatrixXd F, M_w, D_w, K_w;    ///< n_c x n_u
  Eigen::MatrixXd S;                   ///< n_y x n_rows
  Eigen::MatrixXd Y_p, Y_v, Y_a;       ///< n_y x n_c
  Eigen::MatrixXd R_p, R_v, R_a, D_u;  ///< n_y x n_u
  Eigen::VectorXd u_0, y_0;            ///< n_u, n_y, at the position itself

  Eigen::Index n_inputs() const { return F.cols(); }
  Eigen::Index n_outputs() const { return S.rows(); }
};

/// Errors: as Lineariser.
MixedSignals mixed_signals(const MixedModel& mixed, const MixedState& state,
                           const std::vector<SceneSignal>& inputs,
                           const std::vector<SceneSignal>& outputs);

/// y_0 (n_y) of reactions alone, N or N m. Errors: likewise.
Eigen::VectorXd reactions_at_rest(const MixedModel& mixed, const MixedState& state,
                                  const std::vector<SceneSignal>& reactions);

}  // namespace stillframe
