#pragma once

#include "judge/run_analysis.hpp"
#include "report/analysis/log_analyser.hpp"
#include "report/analysis/signal_analyser.hpp"
#include "report/verdict/verdict.hpp"

namespace stillframe::judge {

/// Puts levels and spectra of one direction into a verdict, what is asked of it and what its
/// signals come to in these ranges. floor: nullptr, none goes with it; passive, active: nullptr,
/// that loop did not run on this floor; forces: of the active frame, nullptr: there are none, or
/// they are not known. verdict: with its runs and ranges.
void add_levels(const SceneAcceptance& accept, const std::string& axis,
                const report::SignalAnalysis* floor, const report::SignalAnalysis* passive,
                const report::SignalAnalysis* active, const report::ForcesPart* forces,
                report::Verdict& verdict);

/// What analysed logs come to, judged by what the scene in the log of the active loop asks for.
report::Verdict verdict_of(const RunAnalyses& runs);

}  // namespace stillframe::judge
