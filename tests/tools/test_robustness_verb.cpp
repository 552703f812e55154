#include <cmath>
#include <cstdlib>

#include "tests/tools/verb.hpp"
#include "tools/robustness_spread.hpp"
#include "tools/robustness_text.hpp"

namespace stillframe::test {
namespace {

using Json = nlohmann::json;

class RobustnessVerb : public Verb {
 protected:
  /// Arguments of a run on the metrology frame with the uncertainty of config/.
  std::vector<std::string> frame(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"robustness", config("scenes/metrology_frame.yaml"),
                                       "--uncertainty", config("uncertainty/piezo_frame.yaml")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  /// Runs without a search and answers the record that was written.
  std::string record(const std::string& name, const std::vector<std::string>& more = {},
                     const std::string& seed = "5") const {
    std::vector<std::string> arguments{"--samples",   "61",    "--seed",      seed,
                                       "--no-search", "--out", folder_ / name};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Said said = run(frame(arguments));
    EXPECT_EQ(said.exit_code, 0) << said.error;
    EXPECT_EQ(said.error, "");
    return text_of(folder_ / name);
  }

  /// What --json prints, by way of a file: it is more than a pipe holds.
  Json long_json(const std::vector<std::string>& arguments) const {
    std::string command = std::string(STILLFRAME_BIN_DIR) + "/stillframe";
    for (const std::string& word : arguments) command += " '" + word + "'";
    command += " --json > '" + (folder_ / "json").string() + "'";
    EXPECT_EQ(std::system(command.c_str()), 0);
    return Json::parse(text_of(folder_ / "json"));
  }
};

// A bin of 0.005 holds the whole spread: its middle is below the least that was found.
TEST(RobustnessPage, NoQuantileIsBeyondTheExtremes) {
  robustness::Histogram histogram{.width = 0.005, .first = -200, .last = 199, .counts = {}};
  robustness::Extremes extremes;
  EXPECT_TRUE(std::isnan(tools::quantile_within(histogram, extremes, 0.5)));
  for (const double value : {0.0036, 0.0041, 0.0049, 0.0101}) {
    histogram.add(value);
    extremes.add(value);
  }
  EXPECT_EQ(histogram.quantile(0.05), 0.0025);
  EXPECT_EQ(tools::quantile_within(histogram, extremes, 0.05), 0.0036);
  EXPECT_EQ(tools::quantile_within(histogram, extremes, 1), 0.0101);
}

robustness::Outcome outcome_of(double damping, double gain, double highest) {
  robustness::Outcome outcome;
  outcome.verdict = robustness::Outcome::Verdict::stable;
  outcome.radius = 0.99;
  outcome.decay = 10;
  outcome.damping = damping;
  outcome.gain = Eigen::Vector3d::Constant(gain);
  outcome.highest = Eigen::Vector3d(gain, highest, gain);
  outcome.peak = highest;
  return outcome;
}

// What is largest in the picture is the peak of the table, and where the resonances of the plants
// are, all of it is as high.
TEST(RobustnessPicture, HoldsThePeaks) {
  robustness::Record record;
  record.frequencies_hz = Eigen::Vector3d(1, 10, 100);
  record.sample_time = 1e-3;
  record.tally = robustness::Tally(3);
  for (std::uint64_t i = 0; i < 100; ++i) {
    record.tally.add(i, {}, outcome_of(0.001, 0.5, 20 + 0.1 * static_cast<double>(i)));
  }
  const tools::Spread spread(record);
  const Eigen::VectorXd hz{{1, 3.1, 3.2, 10, 31, 32, 100}}, most = spread.most(hz);
  for (const Eigen::Index i : {2, 3, 4}) {  // nearest to 10 Hz by their ratio
    EXPECT_NEAR(most(i), 29.9, 1e-9) << hz(i);
    // The middles of bins of 0.05 dB.
    EXPECT_NEAR(20 * std::log10(spread.low(hz)(i) / 20.4), 0, 0.03) << hz(i);
    EXPECT_NEAR(20 * std::log10(spread.high(hz)(i) / 29.4), 0, 0.03) << hz(i);
  }
  EXPECT_NEAR(most(0), 0.5, 1e-9);
  EXPECT_NEAR(most(6), 0.5, 1e-9);
}

TEST(RobustnessPicture, BarsOfDampingAreAsFineAsTheData) {
  robustness::Tally tally(3);
  for (std::uint64_t i = 0; i < 200; ++i) {
    tally.add(i, {}, outcome_of(0.001 + 5e-6 * static_cast<double>(i), 1, 2));
  }
  const tools::DampingBars bars = tools::damping_bars(tally, 0.0015);
  EXPECT_DOUBLE_EQ(bars.width, 5e-5);  // 1e-3 / 30, rounded up to 1, 2 or 5
  EXPECT_GE(bars.shares.size(), 19u);
  double sum = 0;
  for (const auto& [from, share] : bars.shares) {
    EXPECT_GT(from, 0.001 - bars.width);
    EXPECT_LT(share, 0.1) << from;  // an even twentieth, and a bin at either end
    sum += share;
  }
  EXPECT_NEAR(sum, 1, 1e-12);
}

TEST_F(RobustnessVerb, ShardsAndThreadsChangeNoBit) {
  const std::string whole = record("whole.json", {"--jobs", "1"});
  EXPECT_EQ(record("two.json", {"--jobs", "2"}), whole);
  EXPECT_NE(record("other.json", {}, "6"), whole);
  std::vector<std::string> merge{"merge"};
  for (const char* shard : {"3", "1", "4", "2"}) {
    const std::string name = std::string("part_") + shard + ".json";
    record(name, {"--shard", std::string(shard) + "/4"});
    merge.push_back(folder_ / name);
  }
  merge.insert(merge.end(), {"--out", folder_ / "all.json"});
  const Said said = run(merge);
  EXPECT_EQ(said.exit_code, 0) << said.error;
  EXPECT_EQ(said.error, "");
  EXPECT_EQ(text_of(folder_ / "all.json"), whole);
  EXPECT_NE(said.output.find("61 of 61 samples"), std::string::npos) << said.output;
}

TEST_F(RobustnessVerb, MissingShardsAreNamed) {
  record("part_2.json", {"--shard", "2/4"});
  record("part_4.json", {"--shard", "4/4"});
  const std::vector<std::string> merge{"merge", folder_ / "part_2.json", folder_ / "part_4.json",
                                       "--out", folder_ / "half.json"};
  const Said said = run(merge);
  EXPECT_EQ(said.exit_code, 0);
  EXPECT_EQ(said.error, "stillframe: note: shards 1, 3 of 4 are missing\n");
  EXPECT_NE(said.output.find("30 of 61 samples (2 of 4 shards)"), std::string::npos);
  const Json document = Json::parse(text_of(folder_ / "half.json"));
  EXPECT_EQ(long_json(merge), document);
  EXPECT_EQ(document["shards"]["done"], Json({2, 4}));
  const Json& counts = document["counts"];
  EXPECT_EQ(
      counts["stable"].get<int>() + counts["unstable"].get<int>() + counts["failed"].get<int>(),
      30);  // 15 of index 1, 5, ... 57 and 15 of 3, 7, ... 59
}

TEST_F(RobustnessVerb, MergeRefusesWhatDoesNotBelongTogether) {
  record("one.json", {"--shard", "1/2"});
  record("again.json", {"--shard", "1/2"});
  record("seed.json", {"--shard", "2/2"}, "6");
  const auto refused = [&](const std::string& other, const std::string& message) {
    expect_refused({"merge", folder_ / "one.json", folder_ / other, "--out", folder_ / "all.json"},
                   2, message);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "all.json"));
  };
  refused("again.json", "shard 1/2 is in " + (folder_ / "one.json").string() + " and in " +
                            (folder_ / "again.json").string());
  refused("seed.json", "they differ in seed (5 and 6)");
  refused("none.json", "none.json: cannot be read");
  record("two.json", {"--shard", "2/2"});
  const auto damaged = [&](const std::string& pointer, const Json& value, const char* message) {
    Json document = Json::parse(text_of(folder_ / "two.json"));
    document[Json::json_pointer(pointer)] = value;
    write("damaged.json", document.dump());
    refused("damaged.json", message);
  };
  damaged("/counts/unstable", -3, "found -3 as a count");
  damaged("/counts/stable", 70, "stable, unstable and failed are ");
  damaged("/shards/done", Json::array(), "and 0 samples belong there");
  damaged("/shards/done", Json({7}), "shards: found 7, allowed are 1 to 2");
  damaged("/histograms/peak_db/counts", Json::array(), "those in peak_db are 0");
  damaged("/histograms/log10_decay_per_s/counts", Json::array(),
          "those in log10_decay_per_s are 0");
  damaged("/histograms/log10_damping_ratio/counts", Json::array(),
          "those in the damping ratios are ");
  for (const char* list : {"largest_singular_values_db", "highest_singular_values_db"}) {
    damaged("/histograms/" + std::string(list) + "/0/counts", Json::array(),
            "those in a histogram of singular values are 0");
  }
  damaged("/nominal/spectral_radius", 2.0, "the spectral radius of the unperturbed loop");
  write("scene.json", "{\"format\": \"other\"}");
  refused("scene.json",
          "scene.json: it is no robustness record: its format is \"other\", allowed is "
          "\"stillframe robustness\"");
  write("verdict.json", "{\"format\": 2}");
  refused("verdict.json", "verdict.json: it is no robustness record: its format is 2, allowed is");
  write("list.json", "[1]");
  refused("list.json", "list.json: it is no robustness record: it has no format");
  write("broken.json", "{\"format\": ");
  refused("broken.json", "broken.json: is no robustness record: parse error at line");
  std::string text = text_of(folder_ / "one.json");
  write("short.json", text.replace(text.find("\"counts\""), 8, "\"c\""));
  refused("short.json", "short.json: is no robustness record: key 'counts' not found");
}

TEST_F(RobustnessVerb, RecordOfSamplesIsReadBackForTheSearch) {
  record("all.json");
  const Json again = long_json(frame({"--from", folder_ / "all.json"}));
  const Json direct = long_json(frame({"--samples", "61", "--seed", "5"}));
  EXPECT_EQ(again, direct);
  expect_documented_keys("robustness", direct);
  EXPECT_EQ(run(frame({"--from", folder_ / "all.json", "--seed", "1"})).exit_code, 2);
  expect_refused({"robustness", config("scenes/metrology_frame.yaml"), "--uncertainty",
                  write("little.yaml", "stiffness: 0.01\n"), "--from", folder_ / "all.json"},
                 2, "all.json is not of this scene: they differ in uncertainty");
}

TEST_F(RobustnessVerb, TellsTheWorstInWords) {
  const auto file = folder_ / "plot.png";
  const auto uncertainty = write("delay.yaml", "stiffness: 0.1\ndelay_samples: 0.3\n");
  const Said said = run({"robustness", config("scenes/metrology_frame.yaml"), "--uncertainty",
                         uncertainty, "--samples", "50", "--plot", file});
  EXPECT_EQ(said.exit_code, 0) << said.error;
  EXPECT_EQ(said.error, "");
  // The lead of 1.5 samples makes up for a delay of 1 and a hold; a shorter delay makes it too
  // much.
  for (const char* words :
       {"7 parameters, seed 1, 50 of 50 samples", "with a confidence of 95 %", "T at 20 Hz, dB",
        "Bins are 0.05 dB, 0.02 decades of decay and\n0.001 decades of damping ratio wide",
        "  delay -0.3 samples\n", "without the delay: stable", "without the stiffness: unstable",
        "of these deviations together the loop is stable"}) {
    EXPECT_NE(said.output.find(words), std::string::npos) << words << "\n" << said.output;
  }
  EXPECT_GT(std::filesystem::file_size(file), 10000u);
}

TEST_F(RobustnessVerb, BadInput) {
  expect_refused({"robustness", config("scenes/metrology_frame.yaml")}, 2,
                 "the key 'uncertainty' is missing; write it, or give --uncertainty FILE");
  expect_refused({"robustness", config("scenes/metrology_frame.yaml"), "--uncertainty",
                  write("none.yaml", "stiffness: 0\n")},
                 2, "nothing of this scene is uncertain");
  expect_refused({"robustness", config("scenes/metrology_frame.yaml"), "--uncertainty",
                  write("stiff.yaml", "stiffnes: 0.1\n")},
                 2, "stiff.yaml:1:1");
  for (const char* shard : {"0/4", "5/4", "1", "1/", "a/b", "-1/4", "1/4x"}) {
    expect_refused(frame({"--shard", shard}), 2, "allowed is I/N with I from 1 to N");
  }
  expect_refused(frame({"--out", folder_ / "none/a.json"}), 2, "there is no folder");
  for (const char* option : {"--samples", "--seed", "--jobs"}) {
    EXPECT_EQ(run(frame({option, "-5"})).exit_code, 2) << option;
    EXPECT_EQ(run(frame({option, "many"})).exit_code, 2) << option;
  }
}

TEST_F(RobustnessVerb, ALoopThatIsUnstableAsModelledIsRefused) {
  const auto law = write("naive.yaml",
                         "legs: [leg_1t, leg_1v, leg_2t, leg_2v, leg_3t, leg_3v]\n"
                         "target_hz: 5\ndamping_ratio: 0.7\nsample_rate_hz: 1000\n"
                         "delay_samples: 1\nleak_hz: 0.05\nrealisation: naive_pi\n");
  expect_refused(frame({"--controller", law, "--samples", "5"}), 3, "is not stable");
}

}  // namespace
}  // namespace stillframe::test
