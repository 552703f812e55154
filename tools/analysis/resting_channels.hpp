#pragma once

#include <string>
#include <vector>

#include "tools/analysis/run_analysis.hpp"

namespace stillframe::tools {

/// Accelerations of the frame and of floor monitors that never change by a bit in a log, though the
/// model makes them move of what did: of the floor's inputs that changed, or of forces besides.
/// None of a run without a model. Directions in which symmetry lets nothing move are none of them.
std::vector<std::string> resting_channels(const RunAnalysis& run);

/// Legs whose applied force never changes by a bit though their commands do.
std::vector<std::string> resting_forces(const RunAnalysis& run);

}  // namespace stillframe::tools
