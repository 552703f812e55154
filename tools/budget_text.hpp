#pragma once

#include <string>
#include <vector>

#include "judge/budget_run.hpp"
#include "tools/json.hpp"

namespace stillframe::tools {

/// The tables of a budget, and of the runs that it was held against.
std::string budget_text(const std::string& title, const judge::Budget& budget,
                        const std::vector<judge::BudgetRun>& runs, double within);

/// The same with all digits and all bands; the keys are in the help of `stillframe budget`.
Json budget_json(const std::string& title, const judge::Budget& budget,
                 const std::vector<judge::BudgetRun>& runs, double within);

}  // namespace stillframe::tools
