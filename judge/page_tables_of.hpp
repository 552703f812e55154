#pragma once

#include <cstdint>
#include <string>

#include "controller/gains.hpp"
#include "judge/run_analysis.hpp"
#include "report/page/page_data.hpp"
#include "report/verdict/verdict.hpp"

namespace stillframe::judge {

// The words and tables of the report.

/// Day and time in UTC, so that the same log makes the same page everywhere; us: since 1970.
std::string date_of(std::int64_t us);
page::Head head_of(const RunAnalyses& runs, const report::Verdict& verdict);
/// What a reader must know before believing a number, the worst first.
std::vector<page::Warning> warnings_of(const RunAnalyses& runs, const report::Verdict& verdict);
std::vector<page::AxisResult> results_of(const report::Verdict& verdict);
/// Badge, reasons and headline.
void add_judgement(const report::Verdict& verdict, page::Head& head);
/// What was asked, shocks, noise, effort, timing and what was identified.
void add_tables(const report::Verdict& verdict, page::PageData& page);
/// How whole the logs are.
void add_log_tables(const RunAnalyses& runs, page::PageData& page);
std::vector<page::MatrixTable> gain_tables(const controller::Gains& gains);

}  // namespace stillframe::judge
