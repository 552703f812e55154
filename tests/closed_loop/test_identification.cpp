#include <fstream>

#include "report/log/run_log.hpp"
#include "tests/closed_loop/workspace.hpp"

namespace stillframe::test {
namespace {

using nlohmann::json;

class ClosedLoop : public Workspace {};

void expect_same_run(const std::filesystem::path& first, const std::filesystem::path& second,
                     std::size_t n_samples) {
  const auto a = report::read_run_log(first), b = report::read_run_log(second);
  EXPECT_EQ(a.seq.size(), n_samples);
  EXPECT_EQ(a.command_seq.size(), n_samples);
  ASSERT_EQ(a.seq, b.seq);
  ASSERT_EQ(a.command_seq, b.command_seq);
  EXPECT_TRUE(a.time_s == b.time_s);
  EXPECT_TRUE(a.floor_acceleration == b.floor_acceleration);
  EXPECT_TRUE(a.sigma == b.sigma);
  EXPECT_TRUE(a.applied_force == b.applied_force);
  EXPECT_TRUE(a.frame_acceleration == b.frame_acceleration);
  EXPECT_TRUE(a.command_force == b.command_force);
  EXPECT_EQ(a.n_saturated, b.n_saturated);
}

TEST_F(ClosedLoop, IdentifiedSingularValuesAreThePredictedOnes) {
  draw_pictures();
  // To the bit what the two processes do (OneProcessCarriesTheBitsOfTwo), in a fifth of the time;
  // an own law runs on a multisine over LCM (tests/own_law).
  const Said said =
      run({"run", config("scenes/metrology_frame.yaml"), "--floor", config("floors/multisine.yaml"),
           "--mode", "single_process", "--out", folder_ / "run", "--json"});
  ASSERT_EQ(said.exit_code, 0) << said.error;
  const json verdict = json::parse(said.output);
  for (const auto& run : verdict.at("runs")) {
    EXPECT_EQ(run.at("n_lost"), 0) << run.at("loop");
    std::cout << run.at("loop") << ": " << run.at("real_time_factor") << " times real time\n";
  }
  const json& found = verdict.at("identification");
  std::cout << "largest deviation from the sampled-data prediction: open "
            << found.at("open_largest_db") << " dB, closed " << found.at("closed_largest_db")
            << " dB at " << found.at("n_frequencies") << " frequencies\n";
  EXPECT_EQ(found.at("n_frequencies"), 50);
  EXPECT_EQ(found.at("n_compared"), 600);  // all are coherent
  EXPECT_LE(found.at("lowest_hz"), 0.5);
  EXPECT_GE(found.at("highest_hz"), 200.0);
  // 0.1 dB is what a run has to meet. An undisturbed lock-step run has only nonlinearity and
  // integrator tolerance to err by; both are below 0.01 dB (tests/plant_sim/test_prediction.cpp),
  // so more than that is a defect.
  EXPECT_LT(found.at("open_largest_db"), 0.02);
  EXPECT_LT(found.at("closed_largest_db"), 0.02);
  EXPECT_LT(found.at("reduction_largest_error_db"), 0.04);
  EXPECT_EQ(found.at("n_closed_below_open"), found.at("n_reduction_frequencies"));
  for (const char* file :
       {"active.lcm", "passive.lcm", "scene.yaml", "floor.yaml", "gains.yaml", "verdict.json",
        "verdict.txt", "report.html", "singular_values.png", "prediction_error.png"}) {
    EXPECT_GT(std::filesystem::file_size(folder_ / "run" / file), 0u) << file;
  }
}

TEST_F(ClosedLoop, TwoLockStepRunsCarryTheSameBits) {
  for (const char* name : {"a", "b"}) {
    const Said said = run({"run", config("scenes/metrology_frame.yaml"), "--duration", "4",
                           "--loop", "active", "--run-id", "7", "--out", folder_ / name});
    ASSERT_EQ(said.exit_code, 0) << said.error;
  }
  expect_same_run(folder_ / "a/active.lcm", folder_ / "b/active.lcm", 4001);
}

TEST_F(ClosedLoop, OneProcessCarriesTheBitsOfTwo) {
  // The default scene, and one with gravity, noise, a blow on the frame, a lag and a delay in
  // parts.
  std::ifstream original(config("scenes/frame_under_gravity.yaml"));
  std::string scene(std::istreambuf_iterator<char>(original), {});
  scene += R"(
instruments: {actuator_lag_hz: 800, force_sensors: {noise_n_per_sqrt_hz: 1e-3}}
disturbances: [{name: blow, node: lens, along: x, force: {impact: {peak: 3, width_s: 0.01, at_s: 0.2}}}]
)";
  std::filesystem::create_directories(folder_ / "config/scenes");
  for (const char* part : {"controllers", "floors"}) {
    std::filesystem::copy(config(part), folder_ / "config" / part,
                          std::filesystem::copy_options::recursive);
  }
  const auto rich = folder_ / "config/scenes/rich.yaml";
  std::ofstream(rich) << scene;
  int number = 0;
  for (const auto& file : {config("scenes/metrology_frame.yaml"), rich}) {
    ++number;
    for (const char* mode : {"lock_step", "single_process"}) {
      const Said said = run({"run", file, "--duration", "1", "--run-id", "7", "--mode", mode,
                             "--out", folder_ / (std::string(mode) + std::to_string(number))});
      ASSERT_EQ(said.exit_code, 0) << said.error;
    }
    for (const char* loop : {"passive.lcm", "active.lcm"}) {
      SCOPED_TRACE(file.string() + ", " + loop);
      expect_same_run(folder_ / ("lock_step" + std::to_string(number)) / loop,
                      folder_ / ("single_process" + std::to_string(number)) / loop,
                      number == 1 ? 1001 : 5001);  // of a second at the scene's rate
    }
  }
}

TEST_F(ClosedLoop, TheLogNeedsNoOtherFile) {
  ASSERT_EQ(run({"run", config("scenes/metrology_frame.yaml"), "--duration", "2", "--loop",
                 "active", "--out", folder_ / "run"})
                .exit_code,
            0);
  const auto log = report::read_run_log(folder_ / "run/active.lcm");
  const auto same = [&](const std::string& text, const std::string& file) {
    std::ifstream stream(folder_ / "run" / file);
    return text == std::string(std::istreambuf_iterator<char>(stream), {});
  };
  EXPECT_TRUE(same(log.info.scene_text, "scene.yaml"));
  EXPECT_TRUE(same(log.info.floor_text, "floor.yaml"));
  EXPECT_TRUE(same(log.info.gains_text, "gains.yaml"));
  EXPECT_EQ(log.info.floor_names.size(), 6u);
}

TEST_F(ClosedLoop, RealFloorIsReduced) {
  const Said said = run({"run", config("scenes/metrology_frame.yaml"), "--duration", "20", "--out",
                         folder_ / "run", "--json"});
  ASSERT_EQ(said.exit_code, 0) << said.error;
  const json verdict = json::parse(said.output);
  for (const auto& run : verdict.at("runs")) EXPECT_EQ(run.at("n_lost"), 0) << run.at("loop");
  ASSERT_EQ(verdict.at("axes").size(), 3u);
  for (const auto& axis : verdict.at("axes")) {
    const double floor = axis.at("floor").at("rms_m_s2");
    const double passive = axis.at("passive").at("rms_m_s2");
    const double active = axis.at("active").at("rms_m_s2");
    // Undamped, the passive frame amplifies; isolated, it moves less than the floor.
    EXPECT_GT(passive, floor) << axis.at("axis");
    EXPECT_LT(active, floor) << axis.at("axis");
  }
}

}  // namespace
}  // namespace stillframe::test
