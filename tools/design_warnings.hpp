#pragma once

#include <string>
#include <vector>

#include "tools/loop_design.hpp"

namespace stillframe::tools {

struct DesignAnalysis;

/// What a person should know before switching this loop on, in words, the gravest first.
std::vector<std::string> design_warnings(const LoopDesign& design, const DesignAnalysis& analysis);

}  // namespace stillframe::tools
