#include <algorithm>
#include <regex>

#include "report/log/run_log.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

class SingleProcess : public Verb {};

// The plant takes hundreds of microseconds over a sample here, the law a few: a controller's time
// with the plant's in it is never below a third of the plant's. The machine may take the processor
// away while the law runs, but hardly in five runs of five.
TEST_F(SingleProcess, TheControllersTimeIsItsOwn) {
  std::string scene = text_of(config("scenes/metrology_frame.yaml"));
  scene = std::regex_replace(scene, std::regex("\\.\\./"), config("").string());
  const std::string duration = "  duration_s: 60\n";
  ASSERT_NE(scene.find(duration), std::string::npos);
  scene.replace(scene.find(duration), duration.size(),
                "  method: nodal\n  relative_tolerance: 1e-12\n");
  const auto file = write("scene.yaml", scene);
  double least = 1;
  for (int i = 0; i < 5 && !(least < 1.0 / 3); ++i) {
    const auto out = folder_ / std::to_string(i);
    const Said said = run({"run", file, "--mode", "single_process", "--loop", "active",
                           "--duration", "0.3", "--out", out});
    ASSERT_EQ(said.exit_code, 0) << said.error;
    const report::RunLog log = report::read_run_log(out / "active.lcm");
    ASSERT_TRUE(log.plant_timing && log.controller_timing);
    const auto controller = static_cast<double>(log.controller_timing->worst_compute_ns),
               plant = static_cast<double>(log.plant_timing->worst_compute_ns);
    EXPECT_GT(controller, 0);
    least = std::min(least, controller / plant);
  }
  EXPECT_LT(least, 1.0 / 3);
}

// What a recorded force does is taken off wherever the run is started and its logs are read. It was
// looked for in the working directory then, and the levels of a run from elsewhere were not judged.
TEST_F(SingleProcess, ARecordedForceIsFoundFromAnyFolder) {
  std::string csv = "# units=N\n# fs_hz=100\n# n=500\nF\n";
  for (int k = 0; k < 500; ++k) csv += k == 250 ? "0.1\n" : "0\n";
  write("blow.csv", csv);
  std::string scene = text_of(config("scenes/metrology_frame.yaml"));
  scene = std::regex_replace(scene, std::regex("\\.\\./"), config("").string());
  write("scene.yaml", scene +
                          "\ndisturbances: [{name: blow, node: lens, along: z, force: {recording: "
                          "{file: blow.csv, column: F}}}]\n");
  std::filesystem::create_directory(folder_ / "other");
  const auto judged = [&](const std::string& from, const std::string& arguments) {
    const Said said = shell("cd '" + (folder_ / from).string() + "'\nexec $BIN/stillframe " +
                            arguments + " --json");
    EXPECT_EQ(said.exit_code, 0) << from << ": " << said.error;
    auto verdict = nlohmann::json::parse(said.output);
    verdict.erase("timing");
    for (auto& run : verdict.at("runs")) run.erase("real_time_factor");
    return verdict.dump();
  };
  const std::string run = " --mode single_process --duration 12 --run-id 3 --out ",
                    beside = judged("", "run scene.yaml" + run + "a");
  EXPECT_EQ(beside.find("no such file"), std::string::npos);
  EXPECT_TRUE(judged("other", "run ../scene.yaml" + run + "../b") == beside);
  EXPECT_TRUE(judged("other", "report ../a") == beside);
}

}  // namespace
}  // namespace stillframe::test
