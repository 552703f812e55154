#pragma once

#include <vector>

#include "judge/loop_design.hpp"

namespace stillframe::judge {

/// Hz, the targets of the motion that a loop is designed for: of its feed-forward, if that has one
/// of its own, else of its feedback.
std::vector<double> aimed_hz(const SceneController& controller);
double lowest_aim_hz(const SceneController& controller);

/// The loop whose continuous law does what was aimed at: those targets, without a roll-off and
/// without sampling. Errors: as make_control_loop.
ControlLoop aim_of(const LoopDesign& design);

}  // namespace stillframe::judge
