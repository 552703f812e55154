#pragma once

#include <string>

#include "tools/design_analysis.hpp"
#include "tools/json.hpp"

namespace stillframe::tools {

/// One page that a person can decide from.
std::string design_page(const judge::LoopDesign& design, const DesignAnalysis& analysis);

/// The same with all digits; the keys are in the help of `stillframe design`.
Json design_json(const judge::LoopDesign& design, const DesignAnalysis& analysis);

}  // namespace stillframe::tools
