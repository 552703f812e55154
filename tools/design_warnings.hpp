#pragma once

#include <string>
#include <vector>

#include "judge/loop_design.hpp"

namespace stillframe::tools {

struct DesignAnalysis;

/// The instruments of a scene that the linear analysis leaves out, in one line; empty if there are
/// none.
std::string left_out_of_analysis(const Instruments& instruments);

/// What other settings of rate, lead and roll-off would mend: a thin margin, a rate near its
/// limits. Of the analysis margins->all_disk and rates are used.
std::vector<std::string> settings_warnings(const LoopSettings& settings, double target_hz,
                                           const DesignAnalysis& analysis);

/// What every loop of this kind has, more or less: a report that must not be late, a band in which
/// the frame moves more than without control. Of the analysis radius and misaligned_radius are
/// used.
std::vector<std::string> standing_warnings(const LoopSettings& settings, double target_hz,
                                           const DesignAnalysis& analysis);

/// What a person should know before switching this loop on, in words, the gravest first.
std::vector<std::string> design_warnings(const judge::LoopDesign& design,
                                         const DesignAnalysis& analysis);

}  // namespace stillframe::tools
