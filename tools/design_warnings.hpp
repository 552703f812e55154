#pragma once

#include <string>
#include <vector>

#include "judge/loop_design.hpp"
#include "tools/remarks.hpp"

namespace stillframe::tools {

struct DesignAnalysis;

/// The instruments of a scene that the linear analysis leaves out, in one line; empty if there are
/// none.
std::string left_out_of_analysis(const Instruments& instruments);

/// What other settings of rate, lead and roll-off would mend: a thin margin, a rate near its
/// limits. Of the analysis margins->all_disk and rates are used.
std::vector<std::string> settings_warnings(const LoopSettings& settings, double target_hz,
                                           const DesignAnalysis& analysis);

/// Whether a scene says how old the reported forces are: a default vouches for nothing.
bool states_report_age(const Scene& scene);

/// What every loop of this kind has, more or less: a report that must not be late, a band in which
/// the frame moves more than without control. age_is_stated: states_report_age. Of the analysis
/// radius and misaligned_radius are used.
Remarks standing_remarks(const LoopSettings& settings, double target_hz, bool age_is_stated,
                         const DesignAnalysis& analysis);

/// What a person should know before switching this loop on, in words, the gravest first.
Remarks design_remarks(const judge::LoopDesign& design, const DesignAnalysis& analysis);

}  // namespace stillframe::tools
