#pragma once

#include <optional>

#include "judge/run_analysis.hpp"
#include "report/page/page_data.hpp"
#include "report/verdict/verdict.hpp"

namespace stillframe::judge {

// The figures of the report, each from what the logs and their own model say.

/// Nothing if neither a prediction nor a measurement of the matrix is there.
std::optional<page::SingularValueFigure> singular_value_figure(const RunAnalyses& runs);
std::vector<page::TransmissibilityAxis> transmissibility_figures(const RunAnalyses& runs,
                                                                 const report::Verdict& verdict);
std::vector<page::HistoryAxis> histories_of(const RunAnalyses& runs);
/// Of the active run.
std::vector<page::LegHistory> leg_forces_of(const RunAnalyses& runs);
page::SpectraFigures spectra_of(const RunAnalyses& runs);
/// Wall-clock runs only.
std::vector<page::Histogram> histograms_of(const RunAnalyses& runs);

}  // namespace stillframe::judge
