#include <fstream>

#include "msgs/clock.hpp"
#include "report/log/run_log.hpp"
#include "tests/closed_loop/workspace.hpp"

namespace stillframe::test {
namespace {

namespace fs = std::filesystem;

/// Files of a run in two processes, changed while its passive loop is running.
class ChangedFiles : public Workspace {
 protected:
  void SetUp() override {
    Workspace::SetUp();
    // Beside each other, and not in the folder that the run is started from.
    fs::create_directories(folder_ / "given");
    write("given/floor.csv", recording("m/s^2", 1e-3));
    write("given/push.csv", recording("N", 0.1));
    write("given/floor.yaml", "recording: {file: floor.csv, scale: 1, axes: {x: z}}\n");
    write("given/controller.yaml", text_of(config("controllers/force_feedback_5hz.yaml")));
    std::string text = text_of(config("scenes/metrology_frame.yaml"));
    for (const auto& [from, to] : {std::pair<std::string, std::string>{
                                       "../controllers/force_feedback_5hz.yaml", "controller.yaml"},
                                   {"../floors/vc_d.yaml", "floor.yaml"}}) {
      text.replace(text.find(from), from.size(), to);
    }
    write("given/scene.yaml",
          text +
              "\ndisturbances: [{name: push, node: lens, along: x, force: {recording: {file: "
              "push.csv, column: x}}}]\n");
  }

  /// 30 s of a square wave of 1 Hz.
  static std::string recording(const std::string& units, double height) {
    std::string text = "# fs_hz=200 n=6000 units=" + units + "\nx\n";
    for (int i = 0; i < 6000; ++i) text += std::to_string(i % 200 < 100 ? height : -height) + "\n";
    return text;
  }

  /// Runs the scene, with `change` once the passive loop has been logged in part; answers with the
  /// exit code.
  int run_with(const std::function<void()>& change) {
    const auto process =
        start({"run", folder_ / "given/scene.yaml", "--duration", "8", "--out", folder_ / "run"});
    const auto log = folder_ / "run.incomplete/passive.lcm";
    const std::int64_t until = monotonic_ns() + 60 * ns_per_s;
    std::error_code error;
    while (!(fs::exists(log) && fs::file_size(log, error) > 100'000) && monotonic_ns() < until) {
      process->wait(0.005);
    }
    change();
    return process->wait(120).value_or(-1);
  }

  void expect_failed(const std::string& file, const std::string& text) {
    EXPECT_EQ(run_with([&] { write(file, text); }), 4) << file;
    EXPECT_EQ(text_of(folder_ / "run.incomplete/FAILED.txt"),
              (folder_ / file).string() + " was changed during the run\n");
    EXPECT_FALSE(fs::exists(folder_ / "run.incomplete/active.lcm"));
    fs::remove_all(folder_ / "run.incomplete");
  }
};

TEST_F(ChangedFiles, ThatARunHasCopiesOfChangeNothing) {
  const std::string scene = text_of(folder_ / "given/scene.yaml"),
                    floor = text_of(folder_ / "given/floor.yaml");
  const int code = run_with([&] {
    write("given/scene.yaml", "title: another\n");
    write("given/controller.yaml", "legs: []\n");
    std::string stronger = floor;
    stronger.replace(stronger.find("scale: 1"), 8, "scale: 7");
    write("given/floor.yaml", stronger);
  });
  EXPECT_TRUE(code == 0 || fs::exists(folder_ / "run")) << code << text_of(folder_ / "stderr");
  for (const char* loop : {"passive.lcm", "active.lcm"}) {
    const auto info = report::read_run_log(folder_ / "run" / loop).info;
    // A log calls recorded forces by their full paths, so that it can be read from anywhere.
    std::string found = info.scene_text;
    const std::string full = '"' + (folder_ / "given/push.csv").string() + '"';
    const auto at = found.find(full);
    ASSERT_NE(at, std::string::npos) << found;
    EXPECT_EQ(found.replace(at, full.size(), "push.csv"), scene);
    EXPECT_EQ(info.floor_text, floor);
    EXPECT_EQ(text_of(folder_ / "run/scene.yaml"), scene);
    EXPECT_EQ(info.floor_text, text_of(folder_ / "run/floor.yaml"));
    EXPECT_EQ(info.gains_text, text_of(folder_ / "run/gains.yaml"));
  }
  EXPECT_EQ(text_of(folder_ / "run/controller.yaml"),
            text_of(config("controllers/force_feedback_5hz.yaml")));
}

TEST_F(ChangedFiles, ThatARunReadsAgainEndIt) {
  expect_failed("run.incomplete/gains.yaml", "K_P: none\n");
  expect_failed("given/floor.csv", recording("m/s^2", 2e-3));
  write("given/floor.csv", recording("m/s^2", 1e-3));
  expect_failed("given/push.csv", recording("N", 0.2));
}

}  // namespace
}  // namespace stillframe::test
