#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/control/design/control_loop.hpp"
#include "core/control/loop_settings.hpp"
#include "core/systems/state_space_model.hpp"
#include "tests/octave/octave.hpp"

namespace stillframe::octave {

/// A scene without a loop: all its inputs and outputs, prescribed motions given by their
/// accelerations.
struct OpenCase {
  std::string name;
  StateSpace system;       ///< with direct inputs only
  Eigen::MatrixXd A_q;     ///< state matrix without the states of the floor
  Eigen::VectorXcd poles;  ///< of A_q, as `stillframe modes` tells them
  Eigen::VectorXd omega;   ///< rad/s
  double sample_time = 0;  ///< s
};

/// A scene with a loop.
struct LoopCase {
  std::string name;
  ControlLoop loop;
  LoopSettings settings;
  Eigen::VectorXd omega, omega_sampled;  ///< rad/s; the second below the Nyquist frequency
};

/// Every scene of config/scenes.
const std::vector<OpenCase>& open_cases();

/// Every scene of config/scenes with a controller, others with one, and one of them with every
/// instrument and every part of the law in turn.
const std::vector<LoopCase>& loop_cases();

/// Whether the virtual legs of the design model are the legs themselves, so that the gains are its.
bool is_designed_on_its_legs(const LoopCase& c);

/// What Octave is given: numbers of the plant, the gains and the settings, no results.
Given given(const OpenCase& c);
Given given(const LoopCase& c);

}  // namespace stillframe::octave
