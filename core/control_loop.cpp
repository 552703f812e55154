#include "core/control_loop.hpp"

#include <numbers>

#include "core/equilibrium.hpp"
#include "core/frequency_response.hpp"
#include "core/yaml/input_error.hpp"

namespace stillframe {

namespace {

void require_accelerations(const std::vector<SceneSignal>& signals, const std::string& what) {
  for (const SceneSignal& signal : signals) {
    if (signal.quantity != Quantity::acceleration) {
      throw InputError(signal.place + ": " + what + " '" + signal.name + "': found a " +
                       unit_of(signal.quantity) + " signal, a control loop needs accelerations");
    }
  }
}

/// Driving stress (as an input) or stress resultant (as an output) of each leg.
std::vector<SceneSignal> leg_signals(const SceneController& controller) {
  std::vector<SceneSignal> signals;
  for (const std::string& leg : controller.legs) {
    SceneSignal signal;
    signal.name = "sigma(" + leg + ")";
    signal.place = controller.place;
    signal.element = leg;
    signal.quantity = Quantity::stress;
    signals.push_back(signal);
  }
  return signals;
}

std::vector<SceneSignal> joined(std::vector<SceneSignal> a, const std::vector<SceneSignal>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

void require_loop_signals(const Scene& scene) {
  if (!scene.controller) throw InputError(scene.file + ": the key 'controller' is missing");
  if (scene.inputs.empty()) throw InputError(scene.file + ": the key 'inputs' is missing or empty");
  if (scene.outputs.empty())
    throw InputError(scene.file + ": the key 'outputs' is missing or empty");
  require_accelerations(scene.inputs, "input");
  require_accelerations(scene.outputs, "output");
  require_accelerations(scene.monitors, "monitor");
}

ControlLoop make_control_loop(const Scene& scene, const Model& model) {
  require_loop_signals(scene);
  const SceneController& controller = *scene.controller;
  const auto legs = leg_signals(controller);
  ControlLoop loop;
  loop.n_w = static_cast<Index>(scene.inputs.size());
  loop.n_y = static_cast<Index>(scene.outputs.size());
  loop.n_legs = static_cast<Index>(legs.size());
  loop.plant = linearise(model, solve_equilibrium(model).motion, joined(scene.inputs, legs),
                         joined(scene.outputs, legs));
  // A driving stress acts on the dofs as -E^T sigma_a, E = D_dF^(e) of the legs.
  const Eigen::MatrixXd E = -loop.plant.B.rightCols(loop.n_legs).transpose();
  loop.legs = leg_matrices(loop.plant.M, loop.plant.K, E);
  loop.gains =
      design_gains(loop.legs, 2 * std::numbers::pi * controller.target_hz, controller.damping_ratio,
                   controller.order, 2 * std::numbers::pi * controller.leak_hz);
  return loop;
}

Eigen::MatrixXcd ControlLoop::open(std::complex<double> s) const {
  return transfer_function(plant, s).topLeftCorner(n_y, n_w);
}

Eigen::MatrixXcd ControlLoop::closed(std::complex<double> s) const {
  return closed_loop(transfer_function(plant, s), n_w, n_y, gains(s));
}

}  // namespace stillframe
