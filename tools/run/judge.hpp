#pragma once

#include "judge/loop_design.hpp"
#include "judge/run_analysis.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "report/verdict/verdict.hpp"
#include "tools/run/run_directory.hpp"

namespace stillframe::tools {

/// From analysed logs to the verdict, and the plots that go with it into the run directory:
/// singular values always; where the floor was a multisine and both loops ran, identified against
/// predicted; else histories and one-third-octave velocities of the scene's comparisons. Where they
/// cannot be drawn, as without gnuplot, standard error says so. Errors: InputError of verdict_of,
/// OutputError.
report::Verdict judge(const judge::LoopDesign& design, const judge::RunAnalyses& runs,
                      const RunDirectory& directory);

}  // namespace stillframe::tools
