#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/systems/frequency_range.hpp"
#include "core/systems/multisine_plan.hpp"
#include "judge/floor_nodes.hpp"
#include "judge/hold_of.hpp"
#include "judge/loop_design.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "report/analysis/log_analyser.hpp"
#include "stillframe_msgs/run_info_t.hpp"

namespace stillframe::judge {

/// What the run_info of a log says of the run, taken apart. A part that another version of the
/// program wrote may not be readable; then the numbers that need no model are still there.
struct RecordedRun {
  std::optional<LoopDesign> design;        ///< the scene with the gains that were used
  std::string unreadable;                  ///< why there is none
  std::optional<MultisinePlan> multisine;  ///< that moved the floor, alone or beside other motions
  FloorNodes nodes = FloorNodes::follow;   ///< by the log's own floor block, if it is readable
  /// Of an active run by the clock, and why it is not known.
  std::optional<Hold> hold;
  std::string hold_unknown;

  /// Whether there is no sample that the loop held its frame in, as far as is known.
  bool never_held() const { return hold && !hold->ever; }
  std::optional<report::Takeover> takeover() const {
    return hold ? std::optional(hold->takeover) : std::nullopt;
  }
};

/// The loop of a scene with gains that are given, whatever they were designed for. Errors:
/// InputError and Refusal of the steps.
LoopDesign loop_design_of(const std::string& scene_text, const controller::Gains& gains,
                          const std::string& source_name);

/// The multisine that moves a floor, alone or beside other motions.
std::optional<MultisinePlan> multisine_in(const floor::FloorSpec& spec);

/// A range of frequencies, and of a multisine that has no line in it all lines, too.
FrequencyRange with_lines(FrequencyRange range, const MultisinePlan& plan);

RecordedRun recorded_run(const stillframe_msgs::run_info_t& info, const std::filesystem::path& log);

/// What there is to look for in the log of a run: the scene's comparisons (on a multisine their
/// signals and the outputs, each by itself), the matrix from floor inputs to the scene's outputs,
/// the lines of a multisine or else frequencies from 0.5 to 200 Hz (below 0.4 of the rate). Judged
/// as long as the loop held the frame.
report::AnalysisPlan analysis_plan(const RecordedRun& run, const stillframe_msgs::run_info_t& info);

}  // namespace stillframe::judge
