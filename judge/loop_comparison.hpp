#pragma once

#include <optional>

#include "judge/run_analysis.hpp"

namespace stillframe::judge {

/// Closed against open loop where both matrices were measured at the same frequencies; above twice
/// the target. Nothing otherwise.
std::optional<report::ReductionCheck> reduction_check(const RunAnalyses& runs, double above_hz);

}  // namespace stillframe::judge
