#include <random>
#include <thread>

#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "tests/tools/verb.hpp"
#include "tools/run/run_directory.hpp"

namespace stillframe::test {
namespace {

namespace fs = std::filesystem;
using tools::RunDirectory;

class RunDirectories : public Verb {
 protected:
  std::string error_of(const fs::path& name) const {
    try {
      RunDirectory directory(name);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  std::vector<std::string> short_run(const fs::path& scene, const std::string& out) const {
    return {"run",    scene,        "--mode", "single_process", "--loop",
            "active", "--duration", "2",      "--out",          (folder_ / out).string()};
  }
};

TEST_F(RunDirectories, AreCalledIncompleteUntilTheEnd) {
  {
    RunDirectory directory(folder_ / "a/b/run///");
    EXPECT_EQ(directory.name(), folder_ / "a/b/run");
    directory.write("file", "text");
    EXPECT_FALSE(fs::exists(folder_ / "a/b/run"));
    directory.finish();
  }
  EXPECT_EQ(text_of(folder_ / "a/b/run/file"), "text");
  EXPECT_FALSE(fs::exists(folder_ / "a/b/run.incomplete"));
}

TEST_F(RunDirectories, NothingThatIsThereIsTouched) {
  fs::create_directories(folder_ / "done");
  fs::create_directories(folder_ / "mine.incomplete");
  write("mine.incomplete/thesis.tex", "years");
  write("file", "");
  fs::create_symlink("nowhere", folder_ / "link");
  for (const char* name : {"done", "done/", "file", "link"}) {
    EXPECT_NE(error_of(folder_ / name).find(": is there already; choose another"),
              std::string::npos)
        << name << error_of(folder_ / name);
  }
  EXPECT_NE(error_of(folder_ / "mine").find("mine.incomplete: is there, of another run"),
            std::string::npos);
  EXPECT_NE(error_of(folder_ / "file/run").find("cannot be made"), std::string::npos);
  for (const char* name : {"", "/"})
    EXPECT_NE(error_of(name).find("--out: found"), std::string::npos);
  EXPECT_EQ(text_of(folder_ / "mine.incomplete/thesis.tex"), "years");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 4);
  { RunDirectory failed(folder_ / "failed"); }
  EXPECT_NE(error_of(folder_ / "failed").find("is what a failed run has left"), std::string::npos);
}

TEST_F(RunDirectories, ANameThatIsTakenMeanwhileIsNotReplaced) {
  RunDirectory directory(folder_ / "run");
  fs::create_directories(folder_ / "run");  // empty, which rename() would replace
  EXPECT_THROW(directory.finish(), OutputError);
  EXPECT_TRUE(fs::is_empty(folder_ / "run"));
  EXPECT_TRUE(fs::exists(folder_ / "run.incomplete"));
}

TEST_F(RunDirectories, ManyThatWantOneNameGetOneEach) {
  std::atomic<int> n_owners = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 16; ++i) {
    threads.emplace_back([&] {
      RunDirectory own(folder_ / "stamp", RunDirectory::Taken::count_on);
      own.finish();
      try {
        RunDirectory one(folder_ / "one");
        ++n_owners;
        one.finish();
      } catch (const InputError&) {
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(n_owners, 1);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 17);
}

/// Both loops of a run have a number that can be said.
TEST_F(RunDirectories, TheSecondLoopHasTheNextNumber) {
  const auto numbered = [&](const std::string& id, const std::string& out) {
    return run({"run", config("scenes/metrology_frame.yaml"), "--mode", "single_process",
                "--duration", "2", "--run-id", id, "--out", folder_ / out});
  };
  for (const char* id : {"0", "-1", "9223372036854775807", "9223372036854775808"}) {
    const Said said = numbered(id, "none");
    EXPECT_EQ(said.exit_code, 2) << id;
    EXPECT_NE(said.error.find("1 to 9223372036854775806"), std::string::npos) << said.error;
  }
  EXPECT_EQ(numbered("9223372036854775806", "run").exit_code, 0);
  const auto number_in = [&](const char* log) {
    return json({"export", folder_ / "run" / log, "--csv",
                 folder_ / "signals.csv"})["files"][0]["run_id"]
        .get<std::string>();
  };
  EXPECT_EQ(number_in("passive.lcm"), "9223372036854775806");
  EXPECT_EQ(number_in("active.lcm"), "9223372036854775807");
}

TEST_F(RunDirectories, OfTwoRunsIntoOneFolderOneIsRefusedAtOnce) {
  const fs::path scene = config("scenes/metrology_frame.yaml");
  std::string text = text_of(scene);
  text.replace(text.find("title:"), 6, "title: Another,");
  // Files that the scene names stand beside it.
  const fs::path other = write("other.yaml", text + "\n# another hash\n");
  std::mt19937 random(12);
  for (int trial = 0; trial < 4; ++trial) {
    const std::string out = "run" + std::to_string(trial);
    const std::vector<std::string> floor{"--floor", config("floors/vc_d.yaml"), "--controller",
                                         config("controllers/force_feedback_5hz.yaml")};
    auto first = short_run(scene, out), second = short_run(other, out);
    first.insert(first.end(), floor.begin(), floor.end());
    second.insert(second.end(), floor.begin(), floor.end());
    const auto a = start(first);
    a->wait(std::uniform_real_distribution(0.0, 0.2)(random));
    const auto b = start(second);
    const auto code_a = a->wait(60), code_b = b->wait(60);
    ASSERT_TRUE(code_a && code_b);
    ASSERT_EQ(std::min(*code_a, *code_b), 0) << text_of(folder_ / "stderr");
    ASSERT_EQ(std::max(*code_a, *code_b), 2) << text_of(folder_ / "stderr");
    const Scene kept =
        read_scene(folder_ / out / "scene.yaml", config("controllers/force_feedback_5hz.yaml"));
    const auto verdict = nlohmann::json::parse(text_of(folder_ / out / "verdict.json"));
    EXPECT_EQ(verdict.at("runs").at(0).at("scene_hash"), kept.hash);
    EXPECT_EQ(kept.text, text_of(*code_a == 0 ? scene : other));
  }
}

TEST_F(RunDirectories, AreWholeWithoutTheirPlotsWhereGnuplotIsMissing) {
  const Said said = shell("PATH=/nowhere exec $BIN/stillframe run '" +
                          config("scenes/metrology_frame.yaml").string() +
                          "' --mode single_process --loop active --duration 2 --out '" +
                          (folder_ / "run").string() + "'");
  EXPECT_EQ(said.exit_code, 0);
  EXPECT_NE(said.error.find("warning: plots: the program gnuplot cannot be started"),
            std::string::npos)
      << said.error;
  EXPECT_TRUE(fs::exists(folder_ / "run/report.html") && fs::exists(folder_ / "run/verdict.json"));
  EXPECT_FALSE(fs::exists(folder_ / "run/accelerations.png"));
}

TEST_F(RunDirectories, DefaultNamesOfOneSecondDiffer) {
  const std::string command =
      "cd '" + folder_.string() + "'\nrun() { $BIN/stillframe run '" +
      config("scenes/metrology_frame.yaml").string() +
      "' --mode single_process --loop active --duration 2; }\nrun & run & run & wait";
  EXPECT_EQ(shell(command).exit_code, 0);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "runs"), {}), 3);
  for (const auto& entry : fs::directory_iterator(folder_ / "runs")) {
    EXPECT_TRUE(fs::exists(entry.path() / "verdict.json")) << entry.path();
  }
}

}  // namespace
}  // namespace stillframe::test
