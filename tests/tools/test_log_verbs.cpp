#include <fstream>

#include "judge/loop_target.hpp"
#include "judge/recorded_run.hpp"
#include "judge/response_prediction.hpp"
#include "judge/run_analysis.hpp"
#include "report/identification/frequency_response.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Eigen::MatrixXcd;
using Json = nlohmann::json;

/// `identify` and `report` on logs of runs in one process.
class LogVerbs : public Verb {
 protected:
  /// The frame on the recorded floor.
  std::filesystem::path recorded(const std::string& loop, const std::string& seconds) const {
    const Said said = run({"run", config("scenes/metrology_frame.yaml"), "--mode", "single_process",
                           "--loop", loop, "--duration", seconds, "--out", folder_ / "run"});
    EXPECT_EQ(said.exit_code, 0) << said.error;
    return folder_ / "run";
  }
};

TEST_F(LogVerbs, AxesOfARecordedFloorAreThePredictedOnes) {
  const auto folder = recorded("active", "32");
  const Json found = json({"identify", folder / "active.lcm"});
  EXPECT_EQ(found.at("loop"), "active");
  EXPECT_NE(found.at("matrix").at("missing").get<std::string>().find("independently"),
            std::string::npos);
  const Json& axes = found.at("axes");
  EXPECT_EQ(axes.at("inputs"), Json({"floor_x", "floor_y", "floor_z"}));
  int compared = 0;
  for (std::size_t l = 0; l < axes.at("frequencies_hz").size(); ++l) {
    const double frequency = axes.at("frequencies_hz")[l];
    for (const Json& error : axes.at("sampled_error_db")[l]) {
      // The recording was sampled at 200 Hz: nothing moves above 100 Hz, and nothing is said.
      if (frequency > 101) {
        EXPECT_TRUE(error.is_null()) << frequency;
      }
      if (error.is_null()) continue;
      ++compared;
      // Against what the model of the log has for a floor that translates: another way from the
      // scene to T than the plant's. A parabola over 0.4 Hz (twice the width of 64 s) leaves up to
      // 0.02 dB of a loop with its poles at 5 Hz; without the sampling it would be 20 dB at 100 Hz.
      EXPECT_LT(std::abs(error.get<double>()), 0.02) << frequency << " Hz";
    }
  }
  EXPECT_GT(compared, 100);
  expect_documented_keys("identify", found);
  expect_documented_keys("identify", axes);
  const std::string page = run({"identify", folder / "active.lcm"}).output;
  EXPECT_NE(page.find(", 1 segment\n"), std::string::npos) << page;
  EXPECT_NE(page.find(" frequencies: the floor moves too little there"), std::string::npos) << page;
}

TEST_F(LogVerbs, AReportIsOneFileAndTheVerdictBesideIt) {
  const auto folder = recorded("both", "6");
  const std::string of_run = text_of(folder / "report.html");
  std::filesystem::remove(folder / "report.html");
  const Json verdict = json({"report", folder, "--verdict", folder_ / "verdict.json"});
  EXPECT_EQ(verdict, Json::parse(text_of(folder_ / "verdict.json")));
  EXPECT_EQ(verdict.at("runs").size(), 2u);
  EXPECT_EQ(verdict.at("axes").size(), 3u);
  EXPECT_EQ(verdict.at("axes")[0].at("active").at("cumulative_rms_m_s2").size(), 20u);
  EXPECT_EQ(verdict.at("transmissibility").size(), 6u);
  EXPECT_EQ(verdict.at("effort").size(), 6u);  // of the active run: a passive one does nothing
  // The page of a run and that of its logs are one and the same.
  EXPECT_EQ(text_of(folder / "report.html"), of_run);
  EXPECT_LT(of_run.size(), 3u << 20);
  EXPECT_GT(of_run.size(), 1u << 20);
  for (const char* part :
       {"<!DOCTYPE html>", "Metrology frame on six piezo legs", "leg_1t", "vc_d", "K_P"}) {
    EXPECT_NE(of_run.find(part), std::string::npos) << part;
  }
  // What the run printed is what the report prints.
  EXPECT_EQ(text_of(folder / "verdict.txt"), [&] {
    const std::string printed = run({"report", folder}).output;
    return printed.substr(0, printed.find("Report: "));
  }());
}

TEST_F(LogVerbs, ATruncatedLogGivesWhatItHolds) {
  const auto folder = recorded("active", "8");
  std::filesystem::resize_file(folder / "active.lcm",
                               std::filesystem::file_size(folder / "active.lcm") / 2 + 77);
  const Said said = run({"report", folder / "active.lcm", "--out", folder_ / "cut.html", "--json"});
  EXPECT_EQ(said.exit_code, 4) << said.error;
  const Json verdict = Json::parse(said.output);
  EXPECT_EQ(verdict.at("outcome"), "failed");
  const Json& run_summary = verdict.at("runs")[0];
  EXPECT_EQ(run_summary.at("n_samples").get<int>() + run_summary.at("n_lost").get<int>(), 8001);
  EXPECT_NEAR(run_summary.at("n_samples").get<double>(), 4000, 30);
  EXPECT_GT(run_summary.at("unread_bytes"), 0);
  EXPECT_GT(verdict.at("axes")[0].at("floor").at("rms_m_s2"), 0);
  const std::string page = text_of(folder_ / "cut.html");
  EXPECT_NE(page.find("cannot be read"), std::string::npos);
}

TEST_F(LogVerbs, WhatCannotBeReadIsSaidInOneLine) {
  expect_refused({"report", folder_ / "none.lcm"}, 2, "none.lcm");
  expect_refused({"identify", folder_ / "none.lcm"}, 2, "none.lcm");
  expect_refused({"report", folder_}, 2, "no run directory");
  std::ofstream(folder_ / "text.lcm") << "this is no log of anything";
  expect_refused({"report", folder_ / "text.lcm"}, 2, "text.lcm");
  const auto folder = recorded("active", "2");
  expect_refused({"report", folder / "active.lcm", folder / "active.lcm"}, 2, "a second log");
  // Each loop of a run has a number of its own.
  expect_refused({"report", folder, "--run-id", "7"}, 2,
                 "--run-id: " + folder.string() + " is a folder, whose loops are runs");
  expect_refused({"report", folder / "active.lcm", "--out", folder_ / "no/such/page.html"}, 2,
                 "page.html");
}

TEST_F(LogVerbs, TheModelOfALogIsThatOfItsScene) {
  const auto folder = recorded("active", "2");
  auto analysis = judge::analyse_run(folder / "active.lcm");
  ASSERT_TRUE(analysis.run.design) << analysis.run.unreadable;
  const auto design = judge::make_loop_design(config("scenes/metrology_frame.yaml"), {});
  judge::LoopDesign& recorded_design = *analysis.run.design;
  // The gains went through YAML, which keeps every bit.
  EXPECT_EQ(recorded_design.gains.K_P, design.gains.K_P);
  EXPECT_EQ(recorded_design.closed.A, design.closed.A);
  const auto target = judge::target_of(recorded_design);
  ASSERT_TRUE(target);
  EXPECT_NEAR(target->frequency_hz, 5, 1e-9);
  EXPECT_NEAR(target->damping_ratio, 0.7, 1e-9);

  // With the scene's inputs the prediction is the design's own T.
  report::ResponseSignals signals;
  for (const auto& input : design.scene.inputs) signals.inputs.push_back(input.name);
  for (const auto& output : design.scene.outputs) signals.outputs.push_back(output.name);
  const judge::ResponsePrediction prediction(recorded_design, signals);
  const double frequency = 17;
  const MatrixXcd exact = transfer(design.closed, 2 * std::numbers::pi * frequency);
  EXPECT_LT((prediction.at({frequency}, true).sampled[0] - exact).norm(), 1e-12 * exact.norm());

  // For a floor that translates, from three directions that are no axes: the columns follow.
  report::ResponseSignals axes{{"floor_x", "floor_y", "floor_z"}, {"lens_x", "lens_y", "lens_z"}};
  const MatrixXcd straight =
      judge::ResponsePrediction(recorded_design, axes).at({frequency}, true).sampled[0];
  // Far below the target the frame follows the floor: the identity, but for what the leak of 0.05
  // Hz and the target's own (f / 5 Hz)^2 take.
  const MatrixXcd low = judge::ResponsePrediction(recorded_design, axes).at({0.3}, true).sampled[0];
  EXPECT_LT((low - MatrixXcd::Identity(3, 3)).norm(), 0.2);
  Eigen::Matrix3d D;
  D << 1, 1, 0, 0, 1, 0, 0, 0, -2;
  for (SceneSignal& monitor : recorded_design.scene.monitors) {
    if (!monitor.name.starts_with("floor_")) continue;
    monitor.direction = D.row(monitor.name.back() - 'x').transpose();
  }
  const MatrixXcd skew =
      judge::ResponsePrediction(recorded_design, axes).at({frequency}, true).sampled[0];
  EXPECT_LT((skew * D - straight).norm(), 1e-12 * straight.norm());
}

/// However often a motion of the floor is named, and by whatever foot, it is one input.
TEST_F(LogVerbs, AMotionOfTheFloorThatIsNamedTwiceIsOneInput) {
  auto design = judge::make_loop_design(config("scenes/metrology_frame.yaml"), {});
  const SceneSignal floor_x =
      *std::find_if(design.scene.monitors.begin(), design.scene.monitors.end(),
                    [](const SceneSignal& signal) { return signal.name == "floor_x"; });
  const auto add = [&](const std::string& name, const Eigen::Vector3d& direction) {
    SceneSignal signal = floor_x;
    signal.name = name;
    signal.direction = direction.normalized();
    design.scene.monitors.push_back(signal);
  };
  add("other_foot_x", {-1, 0, 0});
  add("slanted", {3, 0, 4});
  std::vector<report::AxisPlan> axes{
      {"x", "floor_x", "lens_x"}, {"y", "floor_y", "lens_y"}, {"z", "floor_z", "lens_z"}};
  const MatrixXcd three =
      judge::ResponsePrediction(design, judge::signals_by_motion(design.scene, axes).signals)
          .at({17}, true)
          .sampled[0];
  axes.push_back({"again", "floor_x", "lens_y"});
  axes.push_back({"other foot", "other_foot_x", "lens_x"});
  axes.push_back({"slanted", "slanted", "lens_x"});
  const report::AxisSignals signals = judge::signals_by_motion(design.scene, axes);
  EXPECT_EQ(signals.signals.inputs, (std::vector<std::string>{"floor_x", "floor_y", "floor_z"}));
  EXPECT_EQ(signals.signals.outputs, (std::vector<std::string>{"lens_x", "lens_y", "lens_z"}));
  EXPECT_EQ(signals.dependent_floors, (std::vector<std::string>{"other_foot_x", "slanted"}));
  const MatrixXcd T = judge::ResponsePrediction(design, signals.signals).at({17}, true).sampled[0];
  EXPECT_EQ(T, three);
  // |T_xx| beside a floor along x, whoever tells of it; along (3, 0, 4) / 5 both columns of it.
  const auto of = [&](std::size_t a) {
    const Eigen::VectorXd along = signals.along.row(static_cast<Eigen::Index>(a)).transpose();
    return std::complex<double>((T.row(signals.output[a]) * along).value());
  };
  const double rounding = 1e-12 * T.norm();
  EXPECT_LE(std::abs(of(0) - T(0, 0)), rounding);
  EXPECT_LE(std::abs(of(3) - T(1, 0)), rounding);
  EXPECT_LE(std::abs(of(4) + T(0, 0)), rounding);
  EXPECT_LE(std::abs(of(5) - 0.6 * T(0, 0) - 0.8 * T(0, 2)), rounding);
  // What two inputs of one motion do apart, nothing tells.
  const report::ResponseSignals twice{{"floor_x", "floor_y", "floor_x"}, {"lens_x"}};
  EXPECT_THROW(judge::ResponsePrediction(design, twice), InputError);
}

}  // namespace
}  // namespace stillframe::test
