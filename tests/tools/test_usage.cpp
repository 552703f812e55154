#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

/// What a newcomer tries first.
class Usage : public Verb {};

TEST_F(Usage, HelpNamesEveryVerbAndExitCodes) {
  const Said said = run({"--help"});
  EXPECT_EQ(said.exit_code, 0);
  for (const char* word :
       {"modes",  "equilibrium", "buckling",  "linearise", "sigma",    "design",       "feedback",
        "budget", "robustness",  "merge",     "run",       "identify", "report",       "batch",
        "ctl",    "replay",      "export",    "watch",     "sweep",    "superelement", "import",
        "0 done", "2 bad usage", "3 refused", "4 a run"}) {
    EXPECT_NE(said.output.find(word), std::string::npos) << word;
  }
}

TEST_F(Usage, EveryVerbOfAnalysisHasAnExample) {
  for (const char* verb : {"modes", "equilibrium", "buckling", "linearise", "sigma", "superelement",
                           "import", "robustness", "sweep", "commission"}) {
    const Said said = run({verb, "--help"});
    EXPECT_EQ(said.exit_code, 0);
    EXPECT_NE(said.output.find(std::string("Example: stillframe ") + verb), std::string::npos)
        << said.output;
    EXPECT_NE(said.output.find("Keys of --json"), std::string::npos) << said.output;
  }
}

TEST_F(Usage, WrongVerbIsAnsweredWithTheRightOnes) {
  expect_refused(
      {"linearize", "scene.yaml"}, 2,
      "there is no verb 'linearize' (did you mean 'linearise'?); allowed: modes, "
      "equilibrium, buckling, linearise, sigma, superelement, import, design, feedback, budget, "
      "robustness, "
      "merge, sweep, "
      "run, batch, ctl, watch, replay, rig, commission, identify, report, export");
}

TEST_F(Usage, BadUsageIsExitCode2) {
  for (const char* verb :
       {"modes", "equilibrium", "buckling", "linearise", "sigma", "robustness"}) {
    EXPECT_EQ(run({verb}).exit_code, 2) << verb;
    EXPECT_EQ(run({verb, config("scenes/cart.yaml"), "--jason"}).exit_code, 2) << verb;
    expect_refused({verb, folder_ / "none.yaml"}, 2, "none.yaml: cannot be read");
  }
  EXPECT_EQ(run({"buckling", config("scenes/euler_column.yaml"), "--count", "0"}).exit_code, 2);
}

}  // namespace
}  // namespace stillframe::test
