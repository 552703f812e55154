#pragma once

#include <optional>

#include "report/verdict/verdict.hpp"
#include "tools/analysis/run_analysis.hpp"

namespace stillframe::tools {

/// What analysed logs come to. Where both loops ran on a multisine they are judged against the
/// prediction; target_hz: of the design, if it is known, above twice which the loop is to reduce
/// (logs do not hold it; without it the frequency is taken from the gains, loop_target.hpp).
report::Verdict verdict_of(const RunAnalyses& runs, std::optional<double> target_hz = {});

}  // namespace stillframe::tools
