#pragma once

#include <optional>

#include "judge/loop_design.hpp"

namespace stillframe::judge {

/// What one target the gains of a loop aim at: X = I + K_P and K_I = 2 zeta omega_d X with
/// X = K M^-1 / omega_d^2, if there is such a target to 1e-6. Gains of several targets, of virtual
/// legs or of another model have none.
struct LoopTarget {
  double frequency_hz = 0, damping_ratio = 0;
};
std::optional<LoopTarget> target_of(const LoopDesign& design);

/// What an axis of frequency of a recorded run shows: by the targets its gains file names, or the
/// one that its gains aim at.
FrequencyRange axis_of(const LoopDesign& design);

}  // namespace stillframe::judge
