#pragma once

#include <string>
#include <vector>

#include "core/control/close_loop.hpp"
#include "core/control/design/gain_design.hpp"
#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/mechanics/scene/scene.hpp"

namespace stillframe {

/// The generalised plant of a scene with a controller (deck, section 11.2): inputs w (the scene's
/// accelerations) then u (driving stresses of the legs); outputs y (the scene's outputs) then sigma
/// of the legs.
struct ControlLoop {
  LinearModel plant;
  Eigen::Index n_w = 0, n_y = 0, n_legs = 0;
  DesignModel design;
  ForceFeedback gains;  ///< of the continuous law: the lead is what sampling does not use up

  /// G_11, what the floor does to the frame without control.
  Eigen::MatrixXcd open(std::complex<double> s) const;
  /// T with the continuous law, without sampling, delay and instruments. What runs is the sampled
  /// one: close_loop of core/control/loop_settings.hpp.
  Eigen::MatrixXcd closed(std::complex<double> s) const;
};

/// Driving stress (as an input) or stress resultant (as an output) of each leg.
std::vector<SceneSignal> leg_signals(const SceneController& controller);

/// Inputs (w, u) and outputs (y, sigma) of a loop. Errors: as require_loop_signals.
struct LoopSignals {
  std::vector<SceneSignal> inputs, outputs;
};
LoopSignals loop_signals(const Scene& scene);

/// The linear model behind it: linearises a scene about its operating point with the inputs (w, u)
/// and outputs (y, sigma). Errors: as require_loop_signals and linearise.
LinearModel loop_model(const Scene& scene, const Model& model);

/// The targets of n virtual modes: one for all, or n. Errors: InputError on another number.
std::vector<ModeTarget> mode_targets(const SceneController& controller, Eigen::Index n_modes);

/// Linearises a scene's loop about its operating point and designs its gains. Errors: InputError if
/// the scene has no controller, no inputs or no outputs, or an input that is no acceleration;
/// Refusal as design_gains and leg_matrices.
ControlLoop make_control_loop(const Scene& scene, const Model& model);

/// Checks that a scene has a controller, acceleration inputs and acceleration outputs, as a loop
/// needs them. Errors: InputError.
void require_loop_signals(const Scene& scene);

}  // namespace stillframe
