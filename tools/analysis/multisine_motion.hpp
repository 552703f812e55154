#pragma once

#include <optional>

#include "core/linear/frequency_range.hpp"
#include "report/verdict/verdict.hpp"
#include "tools/analysis/run_analysis.hpp"

namespace stillframe::tools {

/// On a multisine every floor input moves on its own, so no axis is compared: how much every output
/// of the frame makes of all inputs of one size, root of the sum of |T|^2 over inputs and lines
/// in the range that is judged (all lines where none lies there), active against passive. Nothing
/// where either loop was not identified on the same multisine.
std::optional<report::Check> multisine_motion(const RunAnalyses& runs,
                                              const FrequencyRange& judged);

/// What moves beside the lines is no lesser motion than what moves on them: puts the levels of all
/// samples of every frame of a comparison, and of every other output, into the verdict's axes,
/// asked what is asked of them on other floors. Floors are among them where all of the floor is one
/// input, which is not then one of several that move on their own. Nothing where the loops ran on
/// floors of their own. verdict: with its runs and ranges.
void add_multisine_levels(report::Verdict& verdict, const RunAnalyses& runs);

}  // namespace stillframe::tools
