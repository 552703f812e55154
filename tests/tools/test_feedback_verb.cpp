#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;

class FeedbackVerb : public Verb {
 protected:
  std::string frame() const { return config("scenes/metrology_frame.yaml"); }
};

const Json& row_of(const Json& document, const std::string& method) {
  const Json* found = nullptr;
  for (const Json& row : document.at("methods")) {
    if (row.at("method") == method) found = &row;  // the last: the PI that keeps the margin
  }
  return *found;
}

double at_hz(const Json& document, const Json& row, double hz) {
  const auto& frequencies = document.at("frequencies_hz");
  for (std::size_t i = 0; i < frequencies.size(); ++i) {
    if (std::abs(frequencies[i].get<double>() - hz) < 1e-9) {
      return 20 * std::log10(row.at("largest_singular_value")[i].get<double>());
    }
  }
  return NAN;
}

// docs/design.md has these figures. At equal margin each design is worth the next's trouble.
TEST_F(FeedbackVerb, DesignsOnTheSampledLoopIsolateBetterAtTheSameMargin) {
  const Json found = json({"feedback", frame()});
  expect_documented_keys("feedback", found);
  for (const auto& row : found.at("methods")) expect_documented_keys("feedback", row);
  const Json &pi = row_of(found, "pi"), &h2 = row_of(found, "h2"),
             &minimax = row_of(found, "minimax");
  for (const Json* row : {&pi, &h2, &minimax}) {
    EXPECT_GE(row->at("disk"), 0.5) << *row;
    EXPECT_LT(row->at("spectral_radius"), 1) << *row;
    EXPECT_LT(row->at("spectral_radius_off"), 1) << *row;
    EXPECT_LT(row->at("peak"), 1.42) << *row;  // 3 dB
  }
  for (const double hz : {20.0, 50.0}) {
    EXPECT_LT(at_hz(found, h2, hz), at_hz(found, pi, hz) - 6) << hz;
    EXPECT_LT(at_hz(found, minimax, hz), at_hz(found, h2, hz) - 6) << hz;
  }
}

// The law that was written is the one that was judged, and it runs: a multisine tells T of it.
TEST_F(FeedbackVerb, TheLawRunsAsPredicted) {
  const Json found = json({"feedback", frame(), "--minimax", folder_ / "law.yaml"});
  const auto block = write("controller.yaml",
                           "legs: [leg_1t, leg_1v, leg_2t, leg_2v, leg_3t, leg_3v]\n"
                           "target_hz: 5\ndamping_ratio: 0.7\nsample_rate_hz: 1000\n"
                           "delay_samples: 1\nforce_limit_n: 200\nlaw: law.yaml\n");
  const Json design = json({"design", frame(), "--controller", block});
  const Json& row = row_of(found, "minimax");
  EXPECT_NEAR(design.at("margins").at("all_disk"), row.at("disk"), 1e-9);
  // Lines of 4 / window_s, away from 13.9, 20.0, 31.3 and 49.0 Hz.
  const auto floor = write("floor.yaml",
                           "multisine: {frequencies_hz: [6, 10, 16, 24, 36, 56, 80, 128, 200, 300, "
                           "400], amplitude: 0.001, ramp_s: 2, window_s: 2}\n");
  const Said said = run({"run", frame(), "--controller", block, "--floor", floor, "--mode",
                         "single_process", "--out", folder_ / "run", "--json"});
  ASSERT_EQ(said.exit_code, 0) << said.error;
  const Json verdict = Json::parse(said.output);
  const Json& identified = verdict.at("identification");
  // As tests/closed_loop has it for the PI; 4e-5 dB was seen.
  EXPECT_LT(identified.at("closed_largest_db"), 0.02) << identified;
  EXPECT_EQ(identified.at("n_frequencies"), 11);
}

TEST_F(FeedbackVerb, SaysWhereThereIsNone) {
  const std::vector<std::string> asked{"feedback", frame(), "--disk",
                                       "1.9",      "--h2",  folder_ / "law.yaml"};
  const Said said = run(asked);
  EXPECT_EQ(said.exit_code, 3);
  EXPECT_NE(said.error.find("h2: finds none that keeps the margin for the mode of"),
            std::string::npos)
      << said.error;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "law.yaml"));
  expect_refused({"feedback", frame(), "--to-hz", "700"}, 2,
                 "--to-hz: found 700, allowed is from 1.5 targets, 7.5, to 0.4 of the rate, 400");
  expect_refused({"feedback", frame(), "--controller", config("controllers/own_law_1khz.yaml")}, 2,
                 "law: is a feedback already");
  expect_refused({"feedback", config("scenes/cart.yaml")}, 2, "controller");
}

TEST_F(FeedbackVerb, DrawsIsolationAgainstMargin) {
  const Json found = json({"feedback", frame(), "--plot", folder_ / "curve.png"});
  EXPECT_GT(std::filesystem::file_size(folder_ / "curve.png"), 10000u);
  int n = 0;
  for (const Json& point : found.at("curve")) {
    if (point.at("method") != "minimax") continue;
    ++n;
    if (!point.at("bound_db").is_null()) {
      EXPECT_GT(point.at("level_db"), point.at("bound_db"));
    }
    // At 0.5 and more a PI of that margin is worse, and so is H2.
    if (point.at("disk") < 0.5) continue;
    for (const Json& other : found.at("curve")) {
      if (other.at("method") != "minimax" && other.at("disk") >= point.at("disk")) {
        EXPECT_GT(other.at("level_db"), point.at("level_db")) << other;
      }
    }
  }
  EXPECT_GE(n, 5);
}

}  // namespace
}  // namespace stillframe::test
