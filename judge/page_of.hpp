#pragma once

#include "judge/run_analysis.hpp"
#include "report/page/page_data.hpp"
#include "report/verdict/verdict.hpp"

namespace stillframe::judge {

/// The report of analysed logs: what the verdict of them says, with its pictures. Predictions and
/// mode shapes are those of the scene and the gains that the logs hold.
page::PageData page_of(const RunAnalyses& runs, const report::Verdict& verdict);

}  // namespace stillframe::judge
