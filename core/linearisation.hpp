#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/kinematics.hpp"
#include "core/scene/scene.hpp"

namespace stillframe {

struct SignalInfo {
  std::string name, unit;
  Quantity quantity = Quantity::position;
};

/// A linear input-output model in second-order form about a rest configuration,
///   M q'' + D q' + (K + G) q = B u_f - M_r w'' - D_r w' - (K_r + G_r) w,
///   y = Y_p q + Y_v q' + Y_a q'' + R_p w + R_v w' + R_a w'' + D_u u_f,
/// for the n_u inputs asked for: a force or stress is u_f itself; a prescribed motion is w, w' or
/// w'' by its quantity, and every motion column has all three (they are one physical input, THEORY
/// section 2). Columns that do not apply are zero. q is n_d, y is n_y. SI units.
struct LinearModel {
  std::vector<std::string> q_names;
  std::vector<SignalInfo> inputs, outputs;
  Eigen::MatrixXd M, D, K, G;          ///< n_d x n_d
  Eigen::MatrixXd B;                   ///< n_d x n_u
  Eigen::MatrixXd M_r, D_r, K_r, G_r;  ///< n_d x n_u
  Eigen::MatrixXd Y_p, Y_v, Y_a;       ///< n_y x n_d
  Eigen::MatrixXd R_p, R_v, R_a, D_u;  ///< n_y x n_u
};

/// Linearises the model about the scene as written, at rest. Only the inputs and outputs asked for
/// are computed.
///   M = D F^T M D F, D = DF_e^T S_d DF_e, K = DF_e^T S DF_e,
///   G = D F^T (sum_i sigma_i D2_x e_i) D F with sigma of the conditions from J^T sigma = f - D_c^T
///   sigma^c.
/// Source: deck, sections 5 to 8; THEORY section 2. Errors: InputError for an input that is not
/// there (a motion along a direction that is not prescribed, the stress of a rigid element);
/// Refusal if the scene as written is not in equilibrium.
LinearModel linearise(const Model& model, const std::vector<SceneSignal>& inputs,
                      const std::vector<SceneSignal>& outputs);

bool is_motion(Quantity quantity);
std::string unit_of(Quantity quantity);

}  // namespace stillframe
