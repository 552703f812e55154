#pragma once

#include <optional>

#include "core/linear/frequency_range.hpp"
#include "report/verdict/judgement.hpp"
#include "tools/analysis/run_analysis.hpp"

namespace stillframe::tools {

/// On a multisine every floor input moves on its own, so no axis is compared: how much every output
/// of the frame makes of all inputs of one size, root of the sum of |T|^2 over inputs and lines
/// in the range that is judged (all lines where none lies there), active against passive. Nothing
/// where either loop was not identified on the same multisine.
std::optional<report::Check> multisine_motion(const RunAnalyses& runs,
                                              const FrequencyRange& judged);

}  // namespace stillframe::tools
