#pragma once

#include <optional>

#include "core/systems/frequency_range.hpp"
#include "judge/run_analysis.hpp"
#include "report/verdict/verdict.hpp"

namespace stillframe::judge {

/// On a multisine every floor input moves on its own, so no axis is compared: how much every output
/// of the frame makes of all inputs of one size, root of the sum of |T|^2 over inputs and lines
/// in the range that is judged (all lines where none lies there), active against passive. Frames
/// of which a scene asks something else by name are left out, and outputs that make less than
/// least_axis_share of what the largest does without control. Nothing where either loop was not
/// identified on the same multisine.
std::optional<report::Check> multisine_motion(const SceneAcceptance& accept,
                                              const RunAnalyses& runs,
                                              const FrequencyRange& judged);

/// Two signals that are set against each other, by name.
struct ComparedFrame {
  std::string name, floor, frame;  ///< floor: empty, none goes with it
};

/// What is compared on a floor. What moves beside the lines of a multisine is no lesser motion than
/// what moves on them: the frame of every comparison, and every other output; floors are among them
/// where all of the floor is one input, which is not then one of several that move on their own.
/// multisine: null on other floors, where it is the comparisons.
std::vector<ComparedFrame> compared_frames(const Scene& scene, const MultisinePlan* multisine);

/// Puts the levels of all samples of a run on a multisine into the verdict's axes. Nothing where
/// the loops ran on floors of their own. verdict: with its runs and ranges.
void add_multisine_levels(const SceneAcceptance& accept, const RunAnalyses& runs,
                          report::Verdict& verdict);

}  // namespace stillframe::judge
