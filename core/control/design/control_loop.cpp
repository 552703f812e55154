#include "core/control/design/control_loop.hpp"

#include <algorithm>

#include "core/control/loop_settings.hpp"
#include "core/errors/input_error.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/quantity.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe {

namespace {

void require_accelerations(const std::vector<SceneSignal>& signals, const std::string& what) {
  for (const SceneSignal& signal : signals) {
    if (signal.quantity != Quantity::acceleration) {
      throw InputError(signal.place + ": " + what + " '" + signal.name + "': found '" +
                       traits_of(signal.quantity).word +
                       "', a control loop needs 'acceleration' (of a node along a direction)");
    }
  }
}

std::vector<SceneSignal> joined(std::vector<SceneSignal> a, const std::vector<SceneSignal>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

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

void require_loop_signals(const Scene& scene) {
  if (!scene.controller) throw InputError(scene.file + ": the key 'controller' is missing");
  if (scene.inputs.empty()) throw InputError(scene.file + ": the key 'inputs' is missing or empty");
  if (scene.outputs.empty())
    throw InputError(scene.file + ": the key 'outputs' is missing or empty");
  require_accelerations(scene.inputs, "input");
  require_accelerations(scene.outputs, "output");
  require_accelerations(scene.monitors, "monitor");
}

LoopSignals loop_signals(const Scene& scene) {
  require_loop_signals(scene);
  const auto legs = leg_signals(*scene.controller);
  return {joined(scene.inputs, legs), joined(scene.outputs, legs)};
}

LinearModel loop_model(const Scene& scene, const Model& model) {
  const LoopSignals signals = loop_signals(scene);
  return linearise(scene, model, signals.inputs, signals.outputs);
}

std::vector<ModeTarget> mode_targets(const SceneController& controller, Index n_modes) {
  const auto& hz = controller.target_hz;
  const auto& zeta = controller.damping_ratio;
  const size_t n = std::max(hz.size(), zeta.size());
  const auto check = [&](const char* key, size_t given) {
    if (given == 1 || given == static_cast<size_t>(n_modes)) return;
    throw InputError(controller.place + ": " + key + ": found " + std::to_string(given) +
                     " numbers, allowed are one, or one for each of the " +
                     std::to_string(n_modes) + " virtual modes");
  };
  check("target_hz", hz.size());
  check("damping_ratio", zeta.size());
  std::vector<ModeTarget> targets;
  for (size_t i = 0; i < n; ++i) {
    targets.push_back(
        {.omega_d = two_pi * hz[hz.size() == 1 ? 0 : i], .zeta = zeta[zeta.size() == 1 ? 0 : i]});
  }
  return targets;
}

ControlLoop make_control_loop(const Scene& scene, const Model& model) {
  ControlLoop loop;
  loop.plant = loop_model(scene, model);
  const SceneController& controller = *scene.controller;
  loop.n_w = static_cast<Index>(scene.inputs.size());
  loop.n_y = static_cast<Index>(scene.outputs.size());
  loop.n_legs = static_cast<Index>(controller.legs.size());
  // A driving stress acts on the dofs as -E^T sigma_a, E = D_dF^(e) of the legs.
  mass_factors(loop.plant);  // names a dof without mass, which in leg coordinates nobody knows
  const Eigen::MatrixXd E = -loop.plant.B.rightCols(loop.n_legs).transpose();
  loop.design = design_model(loop.plant.M, loop.plant.K, E, controller.reduction,
                             {loop.plant.q_names, controller.legs});
  loop.gains = design_gains(loop.design, mode_targets(controller, loop.design.legs.M.rows()),
                            controller.order);
  loop.gains.leak = two_pi * controller.leak_hz;
  loop.gains.high_pass = two_pi * controller.high_pass_hz;
  loop.gains.roll_off = two_pi * controller.roll_off_hz.value_or(0.0);
  LoopSettings settings;
  settings.feedback = loop.gains;
  settings.law.lead_samples = controller.lead_samples;
  settings.sampling.sample_time = 1 / controller.sample_rate_hz;
  settings.sampling.delay_samples = controller.delay_samples;
  settings.sampling.instruments = scene.instruments;
  loop.gains = continuous_law(settings);
  return loop;
}

Eigen::MatrixXcd ControlLoop::open(std::complex<double> s) const {
  return transfer_function(plant, s).topLeftCorner(n_y, n_w);
}

Eigen::MatrixXcd ControlLoop::closed(std::complex<double> s) const {
  return closed_loop(transfer_function(plant, s), n_w, n_y, gains(s));
}

}  // namespace stillframe
