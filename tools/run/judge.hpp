#pragma once

#include <optional>

#include "plant_sim/floor/floor_block.hpp"
#include "report/log/run_log.hpp"
#include "report/verdict/verdict.hpp"
#include "tools/loop_design.hpp"
#include "tools/run/run_directory.hpp"

namespace stillframe::tools {

/// The logs of a run, passive and active or one of them.
struct RunLogs {
  std::optional<report::RunLog> passive, active;
};

/// From logs to the verdict, and the plots that go with it into the run directory: singular values
/// always; where the floor was a multisine and both loops ran, identified against predicted; else
/// histories and one-third-octave velocities of the scene's comparisons. Errors: InputError of the
/// parts.
report::Verdict judge(const LoopDesign& design, const floor::FloorSpec& floor, const RunLogs& logs,
                      const RunDirectory& directory);

}  // namespace stillframe::tools
