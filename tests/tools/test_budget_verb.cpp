#include <cmath>
#include <regex>

#include "tests/tools/recorded.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;

/// The shipped frame with noisy sensors, on floors of every kind.
class BudgetVerb : public Verb {
 protected:
  void SetUp() override {
    Verb::SetUp();
    std::string scene = text_of(config("scenes/metrology_frame.yaml"));
    scene = std::regex_replace(scene, std::regex("\\.\\./"), config("").string());
    scene_ = write("scene.yaml", scene + R"(
instruments:
  force_sensors: {noise_n_per_sqrt_hz: 1e-4, flicker_below_hz: 5, quantisation_n: 1e-3}
  floor_sensors: {noise: 1e-6}
)");
    // A floor of VC-A asks for more than the 200 N that the shipped loops have, and a limit is not
    // linear.
    for (const std::string name : {"feed_forward_1khz.yaml", "force_feedback_5hz.yaml"}) {
      const std::string text = text_of(config("controllers/" + name));
      write(name,
            std::regex_replace(text, std::regex("force_limit_n: 200"), "force_limit_n: 5000"));
    }
    vc_a_ =
        write("vc_a.yaml", "noise: {vc: A, axes: [x, y, z], high_pass_hz: 0.5, duration_s: 10}\n");
  }

  std::vector<std::string> budget(const std::string& controller, const std::string& floor) const {
    return {"budget", scene_, "--controller", folder_ / controller, "--floor", floor};
  }

  std::string scene_, vc_a_;
};

// The issue's bound is 5 % of the measured rms. What is not linear is all that can differ, and on
// floors that move by micrometres that is nothing; noises scatter from run to run by what the
// budget says itself, of which three are allowed: of 27 numbers less than one in ten trials.
TEST_F(BudgetVerb, IsWhatRunsMeasureOnEveryAxisByEveryMethod) {
  int n_checked = 0;
  for (const std::string controller : {"feed_forward_1khz.yaml", "force_feedback_5hz.yaml"}) {
    for (const std::string& floor :
         {config("floors/vc_d.yaml").string(), config("floors/quake.yaml").string(), vc_a_}) {
      const auto out = folder_ / std::to_string(n_checked);
      // What the scene accepts is no matter of the budget.
      record(scene_, out, {.controller = folder_ / controller, .floor = floor, .duration_s = 10});
      auto arguments = budget(controller, floor);
      arguments.insert(arguments.end(),
                       {"--log", out / "passive.lcm", "--log", out / "active.lcm"});
      const Json found = json(arguments);
      for (const Json& a_run : found.at("runs")) {
        for (const auto& [name, axis] : a_run.at("axes").items()) {
          const double predicted = axis.at("predicted_m_s2"), measured = axis.at("measured_m_s2"),
                       scatter = axis.at("scatter_m_s2");
          const std::string where = controller + " " + floor + " " + a_run.dump() + " " + name;
          EXPECT_LT(std::abs(predicted - measured), 0.05 * measured) << where;
          EXPECT_LT(std::abs(predicted - measured), 1e-3 * measured + 3 * scatter) << where;
          EXPECT_TRUE(axis.at("met")) << where;
          ++n_checked;
        }
      }
    }
  }
  EXPECT_EQ(n_checked, 2 * 3 * 2 * 3);
}

// LQG that hears sigma, what acts and the floor: no law of ours.
TEST_F(BudgetVerb, IsWhatARunByALawOfOnesOwnMeasures) {
  const auto controller = config("controllers/own_law_1khz.yaml");
  const Said run_said = run({"run", scene_, "--controller", controller, "--floor",
                             config("floors/vc_d.yaml"), "--mode", "single_process", "--duration",
                             "10", "--loop", "active", "--out", folder_ / "own"});
  ASSERT_TRUE(run_said.exit_code == 0 || run_said.exit_code == 4) << run_said.error;
  const Json found = json({"budget", scene_, "--controller", controller, "--floor",
                           config("floors/vc_d.yaml"), "--log", folder_ / "own" / "active.lcm"});
  const Json& a_run = found.at("runs").at(0);
  EXPECT_EQ(a_run.at("method"), "feed_forward");
  for (const auto& [name, axis] : a_run.at("axes").items()) {
    const double predicted = axis.at("predicted_m_s2"), measured = axis.at("measured_m_s2"),
                 scatter = axis.at("scatter_m_s2");
    EXPECT_LT(std::abs(predicted - measured), 1e-3 * measured + 3 * scatter) << name;
  }
}

TEST_F(BudgetVerb, SharesAddUpToTheWholeInEveryCell) {
  const Json found = json([&] {
    auto arguments = budget("feed_forward_1khz.yaml", vc_a_);
    arguments.insert(arguments.end(), {"--duration", "10"});
    return arguments;
  }());
  expect_documented_keys("budget", found);
  for (const auto& [axis_name, axis] : found.at("axes").items()) {
    for (const auto& [name, method] : axis.at("methods").items()) {
      const double whole = std::pow(method.at("rms_m_s2").get<double>(), 2);
      double shares = 0;
      std::vector<double> cells(method.at("shared_m2_s4").size(), 0.0);
      for (const auto& [source, part] : method.at("sources").items()) {
        shares += part.at("share_m2_s4").get<double>();
        for (size_t i = 0; i < cells.size(); ++i) {
          cells[i] += part.at("shared_m2_s4")[i].get<double>();
        }
      }
      // Sums of some ten numbers.
      EXPECT_NEAR(shares, whole, 1e-12 * whole) << axis_name << name;
      double sum = 0;
      for (size_t i = 0; i < cells.size(); ++i) {
        EXPECT_NEAR(cells[i], method.at("shared_m2_s4")[i].get<double>(), 1e-12 * whole) << name;
        sum += cells[i];
        EXPECT_NEAR(std::sqrt(std::max(0.0, sum)),
                    method.at("cumulative_rms_m_s2")[i].get<double>(), 1e-6 * std::sqrt(whole));
      }
      // All cells are the rms; noises are integrated to 1e-6.
      EXPECT_NEAR(sum, whole, 1e-5 * whole) << name;
    }
  }
}

TEST_F(BudgetVerb, IsOfTheVeryRun) {
  const Said run_said = run({"run", scene_, "--controller", folder_ / "force_feedback_5hz.yaml",
                             "--floor", config("floors/vc_d.yaml"), "--mode", "single_process",
                             "--duration", "3", "--loop", "active", "--out", folder_ / "short"});
  ASSERT_TRUE(run_said.exit_code == 0 || run_said.exit_code == 4) << run_said.error;
  const auto refused = [&](const std::string& controller, const std::string& floor) {
    auto arguments = budget(controller, floor);
    arguments.insert(arguments.end(), {"--log", folder_ / "short" / "active.lcm"});
    const Said said = run(arguments);
    EXPECT_EQ(said.exit_code, 2) << said.output;
    EXPECT_NE(said.error.find("active.lcm"), std::string::npos) << said.error;
  };
  refused("force_feedback_5hz.yaml", config("floors/quake.yaml"));
  refused("feed_forward_1khz.yaml", config("floors/vc_d.yaml"));
}

}  // namespace
}  // namespace stillframe::test
