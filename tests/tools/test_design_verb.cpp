#include <cmath>
#include <fstream>
#include <iterator>

#include "core/worst.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;

class DesignVerb : public Verb {};

TEST_F(DesignVerb, JsonSaysWhatThePageSays) {
  const std::filesystem::path frame = config("scenes/metrology_frame.yaml");
  const Json document = json({"design", frame});
  expect_documented_keys("design", document);
  EXPECT_EQ(document["closed_loop_poles"].size(), 18u);  // 12 of the frame, 6 of the law
  EXPECT_EQ(document["frequencies_hz"].size(), document["noise_to_acceleration"].size());
  // Six equal legs: both orders are one matrix, and all poles are on their targets.
  for (const char* order : {"exact_order", "deck_order"}) {
    EXPECT_NEAR(document[order]["lowest"].get<double>(), 1, 1e-9) << order;
    EXPECT_NEAR(document[order]["highest"].get<double>(), 1, 1e-9) << order;
  }
  // 1 Hz, where the law hardly acts, and 50 Hz, where it holds the frame still.
  EXPECT_NEAR(document["closed_singular_values"][0][0].get<double>(), 1, 0.05);
  EXPECT_NEAR(document["closed_singular_values"][5][0].get<double>(), 0.01, 1e-4);  // (5 / 50)^2
  const Json margins = document["margins"];
  EXPECT_EQ(margins["leg_gain"].size(), 6u);
  EXPECT_LT(margins["all_gain"][0].get<double>(), 1);
  EXPECT_GT(margins["all_gain"][1].get<double>(), 1);
  const Json rates = document["stable_rates_hz"].back();
  EXPECT_LT(rates[0].get<double>(), 1000);
  EXPECT_GT(rates[1].get<double>(), 1000);
}

TEST_F(DesignVerb, UnequalLegsAreWarnedOfTheDecksOrder) {
  const Said page = run({"design", config("scenes/frame_unequal_legs.yaml")});
  EXPECT_EQ(page.exit_code, 0) << page.error;
  EXPECT_NE(
      page.output.find("the deck's order of the matrices would be unstable here (largest real "
                       "part +8.4 1/s)"),
      std::string::npos)
      << page.output;
}

TEST_F(DesignVerb, SaysWhichInstrumentsItLeavesOut) {
  const std::filesystem::path frame = config("scenes/metrology_frame.yaml");
  std::ifstream file(frame);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto page = [&](const std::string& name, const std::string& instruments) {
    const Said said = run({"design", write(name, text + "\ninstruments: {" + instruments + "}\n"),
                           "--controller", config("controllers/force_feedback_5hz.yaml")});
    EXPECT_EQ(said.exit_code, 0) << said.error;
    return said.output;
  };
  const std::string words = "the analysis leaves them out: ";
  EXPECT_EQ(page("plain.yaml", "actuator_lag_hz: 300").find(words), std::string::npos);
  EXPECT_NE(
      page("loop.yaml", "hysteresis: {width: 0.1, swing_n: 100}").find(words + "hysteresis\n"),
      std::string::npos);
  EXPECT_NE(page("all.yaml",
                 "hysteresis: {width: 0.1, swing_n: 100}, force_rate_limit_n_per_s: 1e4, "
                 "force_sensors: {offset_n: 1}")
                .find(words + "hysteresis, force_rate_limit_n_per_s, force_sensors\n"),
            std::string::npos);
}

TEST_F(DesignVerb, TakesTheGainsOfAnotherScene) {
  const std::filesystem::path rigid = config("scenes/metrology_frame.yaml"),
                              flexible = config("scenes/frame_flexible.yaml");
  const Json own = json({"design", flexible}),
             other = json({"design", flexible, "--design-scene", rigid}),
             reference = json(
                 {"design", rigid, "--controller", config("controllers/force_feedback_5khz.yaml")});
  // Legs whose elongations leave the frame unstrained have the gains of the rigid frame (least
  // strain energy); its numbers are rounded in another order.
  const auto difference = [](const Json& a, const Json& b) {
    double worst = 0;
    for (size_t i = 0; i < a.size(); ++i) {
      for (size_t j = 0; j < a.size(); ++j) {
        worst = worst_of(worst, std::abs(a[i][j].get<double>() - b[i][j].get<double>()));
      }
    }
    return worst;
  };
  EXPECT_LT(difference(own["K_P"], other["K_P"]),
            1e-3);  // of some 40; nodes are rounded in the scene
  EXPECT_EQ(other["order"], reference["order"]);
  EXPECT_NE(own["closed_loop_poles"].size(), reference["closed_loop_poles"].size());
}

TEST_F(DesignVerb, AModelWithoutTheLegsIsRefusedByName) {
  const Said found = run({"design", config("scenes/metrology_frame.yaml"), "--design-scene",
                          config("scenes/cart.yaml")});
  EXPECT_EQ(found.exit_code, 2);
  EXPECT_NE(found.error.find("has no elastic element 'leg_1t'"), std::string::npos) << found.error;
}

TEST_F(DesignVerb, AnUnstableLoopIsPrintedAndRefusedWithoutAFile) {
  const Said found =
      run({"design", config("scenes/frame_under_gravity.yaml"), "--controller",
           config("controllers/force_feedback_5hz.yaml"), "--out", folder_ / "g.yaml"});
  EXPECT_EQ(found.exit_code, 3);
  EXPECT_NE(found.output.find("the sampled loop is not stable"), std::string::npos) << found.output;
  EXPECT_NE(found.output.find("preload takes up to"), std::string::npos) << found.output;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "g.yaml"));
}

}  // namespace
}  // namespace stillframe::test
