#include "core/mechanics/operating_point.hpp"

#include "core/errors/input_error.hpp"
#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/partition/free_model.hpp"
#include "core/mechanics/sparse/sparse_scene.hpp"
#include "core/mechanics/stationarity.hpp"

namespace stillframe {

namespace {

NominalMotion motion_as_written(const Model& model) {
  NominalMotion motion(model);
  motion.state.q_d = model.q_0;
  motion.state.q_d_dot = model.q_dot_0;
  motion.state.q_r = model.q_r_0;
  motion.state.q_r_dot = model.q_r_dot_0;
  motion.state.q_r_ddot = model.q_r_ddot_0;
  Data data(model);
  if (!travel(model, data, MotionState(model), motion.state)) {
    throw Refusal(
        "the operating point as written cannot be reached from the positions of the "
        "nodes; choose smaller values");
  }
  switch (
      accelerations(model, data, motion.state, Eigen::VectorXd::Zero(model.n_e), motion.q_d_ddot)) {
    case DynamicsStatus::position_not_found:
      throw Refusal("the operating point as written cannot be reached");
    case DynamicsStatus::mass_matrix_singular:
      throw Refusal("the mass matrix is singular at the operating point: a dof moves no mass");
    case DynamicsStatus::ok:
      break;
  }
  motion.x = data.x;
  motion.e = data.e;
  return motion;
}

}  // namespace

NominalMotion nominal_motion(const Model& model) {
  if (model.operating_point == OperatingPoint::as_written) return motion_as_written(model);
  return solve_equilibrium(model).motion;
}

LinearModel linearise(const Model& model, const std::vector<SceneSignal>& inputs,
                      const std::vector<SceneSignal>& outputs) {
  const NominalMotion nominal = nominal_motion(model);
  if (model.operating_point == OperatingPoint::equilibrium) {
    require_stationary(model, nominal, inputs, outputs);
  }
  return linearise(model, nominal, inputs, outputs);
}

Model model_of(const Scene& scene) {
  return scene.reduction ? free_model(scene) : make_model(scene);
}

LinearModel linearise(const Scene& scene, const Model& model,
                      const std::vector<SceneSignal>& inputs,
                      const std::vector<SceneSignal>& outputs) {
  if (scene.reduction) return reduced_model(scene, inputs, outputs).linear;
  return linearise(model, inputs, outputs);
}

}  // namespace stillframe
