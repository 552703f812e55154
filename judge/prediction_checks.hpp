#pragma once

#include <optional>
#include <string>
#include <vector>

#include "judge/run_analysis.hpp"
#include "report/verdict/verdict.hpp"

namespace stillframe::judge {

/// That forces besides the floor may have made a difference, where it is not known what they do;
/// empty: it is.
std::string forces_in_doubt(const report::Verdict& verdict);

/// How the measured loops meet their predictions, a check for each thing that was or should have
/// been compared; none fails where forces may be the difference. verdict: with its identification
/// and responses; prediction_db: what the scene asks for.
std::vector<report::Check> prediction_checks(const RunAnalyses& runs,
                                             const report::Verdict& verdict,
                                             std::optional<double> prediction_db);

}  // namespace stillframe::judge
