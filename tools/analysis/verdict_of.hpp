#pragma once

#include "report/analysis/log_analyser.hpp"
#include "report/analysis/signal_analyser.hpp"
#include "report/verdict/verdict.hpp"
#include "tools/analysis/run_analysis.hpp"

namespace stillframe::tools {

/// Levels and spectra of one direction; nullptr: that loop did not run on this floor.
report::AxisLevels axis_levels(const std::string& axis, const report::SignalAnalysis& floor,
                               const report::SignalAnalysis* passive,
                               const report::SignalAnalysis* active);

/// Puts what is asked of the last of a verdict's axes, and what its signals come to in these
/// ranges, into it. forces: of the active frame; nullptr: there are none, or they are not known.
void ask(const SceneAcceptance& accept, const report::SignalAnalysis& floor,
         const report::SignalAnalysis* passive, const report::SignalAnalysis* active,
         const report::ForcesPart* forces, report::Verdict& verdict);

/// What analysed logs come to, judged by what the scene in the log of the active loop asks for.
report::Verdict verdict_of(const RunAnalyses& runs);

}  // namespace stillframe::tools
