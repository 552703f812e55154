#pragma once

#include "judge/loop_design.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "tools/run/phase.hpp"

namespace stillframe::tools {

/// One run in this process, without LCM: the loop of ClosedLoop, its messages written straight into
/// LOOP.lcm of the run directory, as lcm-logger writes those of a lock-step run. options: of the
/// run; its scene, gains and mode are those of the design. Shows progress, stops on Ctrl-C.
/// floor_text: of the floor block, for the log.
PhaseResult run_in_process(const judge::LoopDesign& design, const floor::FloorSpec& floor,
                           const std::string& floor_text, const PhaseOptions& options,
                           const RunDirectory& directory);

}  // namespace stillframe::tools
