#include <fstream>
#include <regex>

#include "tests/closed_loop/workspace.hpp"

namespace stillframe::test {
namespace {

namespace fs = std::filesystem;

/// Every refusal is one message, the right exit code, and no trace of a run.
class BadInput : public Workspace {
 protected:
  void expect_refused(const std::vector<std::string>& arguments, int code,
                      const std::string& message) {
    std::vector<std::string> all = arguments;
    all.insert(all.end(), {"--out", folder_ / "run"});
    const Said said = run(all);
    EXPECT_EQ(said.exit_code, code) << said.error;
    EXPECT_TRUE(std::regex_search(said.error, std::regex(message))) << said.error;
    EXPECT_FALSE(fs::exists(folder_ / "run") || fs::exists(folder_ / "run.incomplete"));
  }

  std::string scene() const { return config("scenes/metrology_frame.yaml"); }

  std::string controller_text() const {
    std::ifstream stream(config("controllers/force_feedback_5hz.yaml"));
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  /// The frame's controller block with lines added, or with some of its text exchanged.
  fs::path controller(const std::string& lines) const {
    return write("controller.yaml", controller_text() + lines);
  }
  fs::path changed_controller(
      const std::vector<std::pair<std::string, std::string>>& changes) const {
    std::string text = controller_text();
    for (const auto& [from, to] : changes) text.replace(text.find(from), from.size(), to);
    return write("controller.yaml", text);
  }

  fs::path recording(const std::string& rows) const {
    write("floor.csv", "# fs_hz=200 n=1000 units=m/s^2\nax,ay,az\n" + rows);
    return write("floor.yaml", "recording: {file: floor.csv, axes: {ax: x}}\n");
  }
};

TEST_F(BadInput, NaiveRealisationIsRefusedWithTheReason) {
  expect_refused({"run", scene(), "--controller", controller("realisation: naive_pi\n")}, 3,
                 "spectral radius.*implicit_feedthrough");
}

TEST_F(BadInput, MissingLeakIsRefusedWithTheReason) {
  const auto file = changed_controller({{"leak_hz: 0.05", "leak_hz: 0"}});
  expect_refused({"run", scene(), "--controller", file}, 3, "leak_hz");
}

TEST_F(BadInput, UnknownKey) {
  expect_refused({"run", scene(), "--controller", controller("leek_hz: 1\n")}, 2,
                 "controller.yaml:11:1: leek_hz: unknown key .did you mean 'leak_hz'");
}

TEST_F(BadInput, MissingScene) {
  expect_refused({"run", folder_ / "none.yaml"}, 2, "none.yaml: cannot be read");
}

TEST_F(BadInput, RecordingWithNaN) {
  expect_refused({"run", scene(), "--floor", recording("0,0,0\n0,nan,0\n")}, 2,
                 "floor.csv:4:3: .*nan");
}

TEST_F(BadInput, RecordingWithAGap) {
  expect_refused({"run", scene(), "--floor", recording("0,0,0\n0,0,0\n")}, 2, "floor.csv.*1000");
}

TEST_F(BadInput, MissingRecording) {
  expect_refused({"run", scene(), "--floor",
                  write("floor.yaml", "recording: {file: none.csv, axes: {ax: x}}\n")},
                 2, "floor.yaml:1:.*none.csv");
}

TEST_F(BadInput, WallClockWithoutDelay) {
  const auto file =
      changed_controller({{"delay_samples: 1", "delay_samples: 0"}, {"lead_samples: 1.5", ""}});
  expect_refused({"run", scene(), "--controller", file, "--mode", "wall_clock"}, 2,
                 "delay_samples: found 0");
}

TEST_F(BadInput, WallClockWithoutForceLimit) {
  const auto file = changed_controller({{"force_limit_n: 200", ""}});
  for (const char* loop : {"passive", "both"}) {
    expect_refused({"run", scene(), "--controller", file, "--mode", "wall_clock", "--loop", loop},
                   3, "no force limit: a wall-clock run needs one");
  }
}

// Nobody can tell without its floor whether the loop takes the blow; what may come of it is said.
TEST_F(BadInput, WallClockWithForcesIsWarnedOf) {
  fs::create_directories(folder_ / "there");
  std::string text(text_of(scene()));
  text = std::regex_replace(text, std::regex("\\.\\./"), config("").string());
  const auto file = write("scene.yaml", text +
                                            "\ndisturbances: [{name: blow, node: lens, along: z, "
                                            "force: {impact: {peak: 20, width_s: 0.02}}}]\n");
  const auto policy = write("policy.yaml", "limits: {free_rate_n_per_s: 10000}\n");
  const auto warned = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"run", file, "--out", folder_ / "there"});
    const Said said = run(arguments);
    EXPECT_EQ(said.exit_code, 2) << said.error;  // the folder is there
    return said.error.find("limits.free_rate_n_per_s") != std::string::npos;
  };
  EXPECT_TRUE(warned({"--mode", "wall_clock"}));
  EXPECT_TRUE(warned({"--mode", "wall_clock", "--loop", "active"}));
  EXPECT_FALSE(warned({"--mode", "wall_clock", "--loop", "passive"}));
  EXPECT_FALSE(warned({"--mode", "wall_clock", "--policy", policy}));
  EXPECT_FALSE(warned({"--mode", "lock_step"}));
}

TEST_F(BadInput, PolicyTooShortForASlowLoop) {
  const auto file = changed_controller({{"sample_rate_hz: 1000", "sample_rate_hz: 20"}});
  expect_refused({"run", scene(), "--controller", file, "--mode", "wall_clock", "--policy",
                  write("policy.yaml", "arming: {duration_s: 0.5}\n")},
                 2, "policy.yaml:1:22: arming.duration_s: found '0.5', allowed at 20 Hz.* 0.8 ");
}

TEST_F(BadInput, UnknownLcmProvider) {
  expect_refused({"run", scene(), "--lcm-url", "nonsense://x"}, 2,
                 "LCM cannot be opened at 'nonsense://x'");
}

TEST_F(BadInput, UnroutedMulticastNamesTheMend) {
  // A network namespace as it is made: loopback down, no route for multicast.
  tools::ChildProcess run("unshare",
                          {"unshare", "--net", std::string(STILLFRAME_BIN_DIR) + "/stillframe",
                           "run", scene(), "--out", folder_ / "run"},
                          folder_ / "stderr");
  ASSERT_EQ(run.wait(60), 2);
  std::ifstream stream(folder_ / "stderr");
  const std::string text(std::istreambuf_iterator<char>(stream), {});
  EXPECT_NE(text.find("ip route add 224.0.0.0/4"), std::string::npos) << text;
  EXPECT_FALSE(fs::exists(folder_ / "run") || fs::exists(folder_ / "run.incomplete"));
}

TEST_F(BadInput, RunDirectoryThatIsThere) {
  fs::create_directories(folder_ / "there");
  const Said said = run({"run", scene(), "--out", folder_ / "there"});
  EXPECT_EQ(said.exit_code, 2);
  EXPECT_NE(said.error.find("is there already"), std::string::npos);
  EXPECT_TRUE(fs::is_empty(folder_ / "there"));
}

TEST_F(BadInput, WrongVerb) {
  const Said said = run({"ruin", scene()});
  EXPECT_EQ(said.exit_code, 2);
  EXPECT_NE(said.error.find("did you mean 'run'"), std::string::npos) << said.error;
}

TEST_F(BadInput, WrongOption) {
  const Said said = run({"run", scene(), "--loop", "sideways"});
  EXPECT_EQ(said.exit_code, 2);
}

}  // namespace
}  // namespace stillframe::test
