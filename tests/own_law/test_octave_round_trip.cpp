#include <cmath>

#include "report/log/run_log.hpp"
#include "tests/closed_loop/workspace.hpp"

// A model goes to Octave, comes back as a law, and runs. Skipped where Octave or its control
// package is not installed.
namespace stillframe::test {
namespace {

using nlohmann::json;

class OwnLawOctave : public Workspace {
 protected:
  static constexpr const char* legs = "legs: [leg_1t, leg_1v, leg_2t, leg_2v, leg_3t, leg_3v]\n";

  void SetUp() override {
    Workspace::SetUp();
    frame_ = config("scenes/metrology_frame.yaml");
    if (shell("octave-cli -qf --eval 'pkg load control'").exit_code != 0) {
      GTEST_SKIP() << "Octave or its control package is not installed; scripts/setup installs them";
    }
  }

  /// Runs Octave; everything it says on its way out is no failure, only its exit code is.
  Said octave(const std::string& arguments) const {
    return shell("cd '" + folder_.string() + "'\nexec octave-cli -qf " + arguments);
  }

  json design(const std::string& controller, std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"design", frame_, "--controller", folder_ / controller,
                                       "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Said said = run(arguments);
    EXPECT_EQ(said.exit_code, 0) << said.error;
    return json::parse(said.output);
  }

  std::filesystem::path block(const std::string& file, const std::string& keys) const {
    return write(file, legs +
                           std::string("target_hz: 5\ndamping_ratio: 0.7\n"
                                       "sample_rate_hz: 1000\ndelay_samples: 1\n"
                                       "force_limit_n: 200\n") +
                           keys);
  }

  std::filesystem::path frame_;
};

void expect_same(const json& a, const json& b, double relative) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < a[i].size(); ++j) {
      const double value = a[i][j];
      EXPECT_NEAR(b[i][j].get<double>(), value, relative * std::abs(value)) << i << ", " << j;
    }
  }
}

TEST_F(OwnLawOctave, ComesBackAndRunsAsPredicted) {
  ASSERT_EQ(run({"design", frame_, "--mat", folder_ / "loop.mat"}).exit_code, 0);
  const Said made = octave(STILLFRAME_SOURCE_DIR "/examples/own_law/lqg.m loop.mat law.mat");
  ASSERT_EQ(made.exit_code, 0) << made.error;
  std::cout << made.output;
  block("own.yaml", "law: law.mat\n");
  const json page = design("own.yaml", {"--out", folder_ / "gains.yaml"});
  EXPECT_LT(page.at("spectral_radius"), 1);
  EXPECT_EQ(page.at("law").at("inputs").size(), 18u);
  EXPECT_TRUE(page.at("margins").at("all_disk").is_number());
  EXPECT_TRUE(page.at("K_P").is_null());

  // As config/floors/multisine.yaml, from 1 Hz on: of lines at whole Hz half of the time is enough.
  const auto floor = write("floor.yaml",
                           "multisine:\n"
                           "  frequencies_hz: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 16, 17, 18, "
                           "22, 23, 24, 25, 26, 27, 28, 29, 33, 35, 37, 39, 41, 43, 45, 47, 51, "
                           "55, 60, 66, 73, 80, 89, 100, 112, 126, 141, 158, 178, 200]\n"
                           "  amplitude: 1e-3\n  ramp_s: 4\n  window_s: 4\n");
  const Said said = run({"run", frame_, "--controller", folder_ / "own.yaml", "--floor", floor,
                         "--out", folder_ / "run", "--json"});
  ASSERT_EQ(said.exit_code, 0) << said.error;
  const json verdict = json::parse(said.output);
  for (const auto& run : verdict.at("runs")) EXPECT_EQ(run.at("n_lost"), 0) << run.at("loop");
  const json found = verdict.at("identification");
  std::cout << "largest deviation from the prediction " << found.at("closed_largest_db")
            << " dB at " << found.at("n_frequencies") << " frequencies\n";
  // As for ours: nonlinearity and the tolerance of the integrator, below 0.01 dB each. What is
  // asked for is 0.1 dB.
  EXPECT_LT(found.at("closed_largest_db"), 0.1);
  EXPECT_GE(found.at("n_frequencies"), 40);

  const Said replayed = run({"replay", folder_ / "run/active.lcm"});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.output << replayed.error;
  const auto log = report::read_run_log(folder_ / "run/active.lcm");
  EXPECT_EQ(log.info.gains_text, text_of(folder_ / "gains.yaml"));
  EXPECT_EQ(log.n_saturated, 0);
}

// Ours, written by design --mat, is the same loop when it comes back as somebody else's; so are its
// gains as numbers, compressed or not.
TEST_F(OwnLawOctave, OursComesBackAsItWas) {
  block("ours.yaml", "leak_hz: 0.05\nlead_samples: 0.33\nfeed_forward: {}\n");
  const json ours = design("ours.yaml", {"--mat", folder_ / "loop.mat"});
  const Said saved = octave(
      "--eval \"load loop.mat; law = whole_law; save('-v7', 'law.mat', 'law'); "
      "save('-v6', 'gains.mat', 'K_P', 'K_I');\"");
  ASSERT_EQ(saved.exit_code, 0) << saved.error;
  block("own.yaml", "law: law.mat\n");
  const json own = design("own.yaml");
  // Resonances without damping magnify what is rounded.
  expect_same(ours.at("closed_singular_values"), own.at("closed_singular_values"), 1e-6);
  EXPECT_NEAR(own.at("margins").at("all_disk"), ours.at("margins").at("all_disk"), 1e-4);
  EXPECT_NEAR(own.at("spectral_radius"), ours.at("spectral_radius"), 1e-6);

  block("numbers.yaml", "leak_hz: 0.05\nlead_samples: 0.33\nfeed_forward: {}\nlaw: gains.mat\n");
  const json numbers = design("numbers.yaml");
  EXPECT_EQ(numbers.at("K_P"), ours.at("K_P"));
  EXPECT_EQ(numbers.at("closed_singular_values"), ours.at("closed_singular_values"));
  EXPECT_TRUE(numbers.at("deck_order").is_null());
}

// Our feedback as somebody else's has the same feed-forward designed beside it. What that aims at
// has no leak there, so ours has next to none.
TEST_F(OwnLawOctave, AFeedForwardIsDesignedBesideIt) {
  block("ours.yaml", "leak_hz: 1.0e-5\nlead_samples: 0.33\nfeed_forward: {}\n");
  const json ours = design("ours.yaml", {"--mat", folder_ / "loop.mat"});
  const Said saved = octave(
      "--eval \"load loop.mat; law = whole_law; kept = ! strncmp('floor:', law.input_names, 6); "
      "law.B = law.B(:, kept); law.D = law.D(:, kept); law.input_names = law.input_names(kept); "
      "save('-v7', 'law.mat', 'law');\"");
  ASSERT_EQ(saved.exit_code, 0) << saved.error;
  block("beside.yaml", "law: law.mat\nfeed_forward: {}\n");
  const json beside = design("beside.yaml");
  EXPECT_EQ(beside.at("feed_forward").at("floor"), ours.at("feed_forward").at("floor"));
  // A leak of 0.05 Hz makes a difference of 7e-3.
  expect_same(ours.at("closed_singular_values"), beside.at("closed_singular_values"), 1e-5);
}

TEST_F(OwnLawOctave, IsRefusedWhereItDoesNotFit) {
  ASSERT_EQ(run({"design", frame_, "--mat", folder_ / "loop.mat"}).exit_code, 0);
  const auto refused = [&](const std::string& change, const std::string& keys, int code,
                           const std::string& what) {
    const Said saved = octave("--eval \"load loop.mat; law = whole_law; " + change +
                              "; save('-v7', 'law.mat', 'law');\"");
    ASSERT_EQ(saved.exit_code, 0) << saved.error;
    block("own.yaml", "law: law.mat\n" + keys);
    const Said said = run(
        {"design", frame_, "--controller", folder_ / "own.yaml", "--out", folder_ / "gains.yaml"});
    EXPECT_EQ(said.exit_code, code) << said.output;
    EXPECT_NE(said.error.find(what), std::string::npos) << said.error;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "gains.yaml"));
  };
  refused("law.C = -3 * law.C; law.D = -3 * law.D", "", 3, "is not stable");
  refused("law.Ts = 2e-3", "", 2, "sample_rate_hz: found 500, allowed is that of the controller");
  refused("law.input_names{2} = 'frame:lens_x'", "", 2, "hears no acceleration of the frame");
  refused("law.A(1, 1) = i", "", 2, "A: found a matrix of complex numbers");
  refused("law.A = sparse(law.A)", "", 2, "A: found a sparse matrix");
  refused("", "lead_samples: 1\n", 2, "lead_samples: is given beside the law");
  refused(
      "law.input_names{end + 1} = 'floor:floor_1t'; law.B(:, end + 1) = 0; law.D(:, end + 1) = 0",
      "feed_forward: {}\n", 2, "which hears the floor itself");
}

}  // namespace
}  // namespace stillframe::test
