#pragma once

#include <cstdint>

#include "judge/run_analysis.hpp"

namespace stillframe::judge {

/// What the floor may do to a frame that no signal of a response tells of: motion of its nodes in
/// directions that are not among the inputs.
struct UnmeasuredFloor {
  std::int64_t n_directions = 0;
  /// dB, how far it may shift compared singular values if the floor moves there as much as along
  /// the inputs: one of them, and a tenth of them or more.
  double largest_db = 0, broadly_db = 0;
};

/// Of a response with a prediction; nothing of any other, nor on a floor whose nodes rest.
/// inputs_are_floors: they are axes' floors, with which all nodes that follow are predicted to
/// move, and not the scene's inputs.
UnmeasuredFloor unmeasured_floor(const LoopDesign& design, const JudgedResponse& response,
                                 bool active, bool inputs_are_floors, FloorNodes nodes);

}  // namespace stillframe::judge
