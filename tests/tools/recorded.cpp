#include "tests/tools/recorded.hpp"

#include <gtest/gtest.h>

#include "core/mechanics/scene/scene_reader.hpp"
#include "judge/loop_design.hpp"
#include "judge/verdict_of.hpp"
#include "plant_sim/floor/floor_block.hpp"
#include "plant_sim/floor_motion.hpp"
#include "tools/run/single_process.hpp"

namespace stillframe::test {

namespace fs = std::filesystem;

void record(const fs::path& scene, const fs::path& out, const RecordOptions& options) {
  const judge::LoopDesign design = judge::make_loop_design(scene, options.controller);
  const auto block = read_floor(design.scene, options.floor);
  ASSERT_TRUE(block);
  const double rate_hz = design.gains.sample_rate_hz;
  const auto spec =
      floor::read_floor_block(block->reader, rate_hz, floor_input_names(design.scene));
  tools::RunDirectory directory(out);
  tools::PhaseOptions phase;
  phase.mode = "single_process";
  phase.duration_s = options.duration_s;
  phase.sample_rate_hz = rate_hz;
  for (const std::string& loop : options.loops) {
    phase.loop = loop;
    ++phase.run_id;
    const auto result = tools::run_in_process(design, spec, block->text, phase, directory);
    ASSERT_EQ(result.exit_code, 0) << result.reason;
  }
  directory.finish();
}

nlohmann::json judged(const judge::RunAnalyses& runs) {
  return nlohmann::json::parse(report::to_json(judge::verdict_of(runs)));
}

nlohmann::json judged(const std::vector<fs::path>& logs) {
  std::vector<judge::LogToAnalyse> to_analyse;
  for (const fs::path& log : logs) to_analyse.push_back({log});
  return judged(judge::analyse_runs(std::move(to_analyse)));
}

nlohmann::json judged(const fs::path& folder) {
  return judged(std::vector<fs::path>{folder / "passive.lcm", folder / "active.lcm"});
}

}  // namespace stillframe::test
