#pragma once

#include <string>
#include <vector>

#include "tools/loop_design.hpp"

namespace stillframe::tools {

struct DesignAnalysis;

/// The instruments of a scene that the linear analysis leaves out, in one line; empty if there are
/// none.
std::string left_out_of_analysis(const Instruments& instruments);

/// What a person should know before switching this loop on, in words, the gravest first.
std::vector<std::string> design_warnings(const LoopDesign& design, const DesignAnalysis& analysis);

}  // namespace stillframe::tools
