#pragma once

#include <vector>

#include "judge/loop_design.hpp"

namespace stillframe::judge {

/// Hz, the targets of the motion that a loop is designed for: of its feed-forward, if that has one
/// of its own, else of its feedback.
std::vector<double> aimed_hz(const SceneController& controller);
double lowest_aim_hz(const SceneController& controller);

/// The loop whose continuous law does what is aimed at: those targets, without a roll-off, a lead
/// and sampling; of gains that are numbers of a file, without targets of a feed-forward, theirs.
/// Errors: as make_control_loop.
ControlLoop aim_of(const LoopDesign& design);

/// The same of a scene whose gains are designed, with its model.
ControlLoop aim_of(const Scene& scene, const Model& model);

}  // namespace stillframe::judge
