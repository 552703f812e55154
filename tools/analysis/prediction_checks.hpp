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

}  // namespace stillframe::tools
