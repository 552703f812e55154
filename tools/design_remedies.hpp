#pragma once

#include <string>

#include "tools/design_analysis.hpp"

namespace stillframe::tools {

/// What widens a thin disk margin of all legs, in words: of roll-offs with the lead that matches,
/// less lead, more leak, higher targets and two of these together, the first that was tried and
/// brings it to least_disk_margin, or else the one that widens it most; says so where none does by
/// a tenth.
std::string what_widens(const judge::LoopDesign& design, double disk);

/// Why `recommend` found no rate, in words: what stands in the way at the highest rate that it
/// looks at, and whether a delay does.
std::string why_none_recommended(const judge::LoopDesign& design);

}  // namespace stillframe::tools
