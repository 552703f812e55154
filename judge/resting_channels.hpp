#pragma once

#include <vector>

#include "judge/run_analysis.hpp"
#include "report/verdict/verdict.hpp"

namespace stillframe::judge {

/// What a log has at rest, to the bit and throughout or for a stretch, where it should move.
///   Accelerations of the frame and of floor monitors that the model makes move of what did: of the
///   floor's inputs that changed, or of forces besides. Directions in which symmetry lets nothing
///   move are none of them.
///   Floor inputs, while a monitor of the same node and direction moves.
///   Sigma of a leg, while its commands move.
/// Nothing of a run without a model but the last.
std::vector<report::RestingChannel> resting_channels(const RunAnalysis& run);

/// Legs whose applied force rests though their commands do not.
std::vector<report::RestingChannel> resting_forces(const RunAnalysis& run);

}  // namespace stillframe::judge
