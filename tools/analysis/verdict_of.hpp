#pragma once

#include <optional>

#include "report/verdict/verdict.hpp"
#include "tools/analysis/run_analysis.hpp"

namespace stillframe::tools {

/// What analysed logs come to. Where both loops ran on a multisine they are judged against the
/// prediction; target_hz: of the design, if it is known, above twice which the loop is to reduce
/// (logs do not hold it; without it the frequency is taken from the gains, see target_of).
report::Verdict verdict_of(const RunAnalyses& runs, std::optional<double> target_hz = {});

/// What one target the gains of a loop aim at: X = I + K_P and K_I = 2 zeta omega_d X with
/// X = K M^-1 / omega_d^2, if there is such a target to 1e-6. Gains of several targets, of virtual
/// legs or of another model have none.
struct LoopTarget {
  double frequency_hz = 0, damping_ratio = 0;
};
std::optional<LoopTarget> target_of(const LoopDesign& design);

}  // namespace stillframe::tools
