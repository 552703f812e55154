#pragma once

#include <optional>
#include <vector>

#include "report/verdict/verdict.hpp"
#include "tools/analysis/run_analysis.hpp"

namespace stillframe::tools {

/// How the measured loops meet their predictions, a check for each thing that was or should have
/// been compared. verdict: with its identification and responses; prediction_db: what the scene
/// asks for.
std::vector<report::Check> prediction_checks(const RunAnalyses& runs,
                                             const report::Verdict& verdict,
                                             std::optional<double> prediction_db);

/// On a multisine every floor input moves on its own, so no axis is compared: how much every output
/// of the frame makes of all inputs of one size, root of the sum of |T|^2 over inputs and lines from
/// 1 to 80 Hz (all lines where none lies there), active against passive. Nothing where either loop
/// was not identified on the same multisine.
std::optional<report::Check> multisine_motion(const RunAnalyses& runs);

}  // namespace stillframe::tools
