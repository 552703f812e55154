#include <algorithm>

#include "controller/flight_file.hpp"
#include "controller/timing_file.hpp"
#include "core/files/whole_file.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

namespace fs = std::filesystem;

/// Programs on a disk that takes no more: /dev/full, and a limit on the size of a file, which stops
/// a write in its midst as a full disk does.
class FullDisk : public Verb {
 protected:
  void SetUp() override {
    Verb::SetUp();
    frame_ = "'" + config("scenes/metrology_frame.yaml").string() + "'";
    here_ = "cd '" + folder_.string() + "'\n";
  }

  void expect_full(const std::string& command, const std::string& message) const {
    const Said said = shell(command);
    EXPECT_EQ(said.exit_code, 1) << command;
    EXPECT_NE(said.error.find(message), std::string::npos) << command << "\n" << said.error;
  }

  /// `arguments` write the file `name`, which would be larger than so many blocks of 512 bytes.
  void expect_whole_or_older(const std::string& name, const std::string& arguments,
                             int most_blocks) const {
    write(name, "an older file");
    expect_full(here_ + "trap '' XFSZ\nulimit -f " + std::to_string(most_blocks) +
                    "\nexec $BIN/stillframe " + arguments,
                name + ": cannot be written: File too large");
    EXPECT_EQ(text_of(folder_ / name), "an older file") << arguments;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      EXPECT_EQ(entry.path().string().find("incomplete"), std::string::npos) << entry.path();
    }
  }

  std::string frame_, here_;
};

TEST_F(FullDisk, IsSaidByEveryVerbWhoseOutputIsOnIt) {
  const std::string run = here_ + "$BIN/stillframe run " + frame_ +
                          " --mode single_process --loop active --duration 2 --out run";
  ASSERT_EQ(shell(run).exit_code, 0);
  write("hanging.yaml", hanging_mass);
  const std::string column = "'" + config("scenes/euler_column.yaml").string() + "'";
  for (const std::string& arguments :
       {std::string("modes hanging.yaml"), std::string("modes hanging.yaml --json"),
        std::string("equilibrium hanging.yaml"), "buckling " + column, "sigma " + frame_,
        std::string("linearise hanging.yaml"), "design " + frame_,
        "robustness " + frame_ + " --samples 5 --no-search --out all.json --uncertainty '" +
            config("uncertainty/piezo_frame.yaml").string() + "'",
        std::string("merge all.json --out merged.json"),
        "run " + frame_ + " --mode single_process --loop active --duration 2",
        std::string("identify run/active.lcm"), std::string("report run"),
        "batch " + frame_ + " --duration 2", std::string("export run/active.lcm --csv a.csv"),
        std::string("replay run/active.lcm"), std::string("--help"), std::string("--version"),
        std::string("design --help")}) {
    expect_full(here_ + "exec $BIN/stillframe " + arguments + " > /dev/full",
                "stillframe: error: standard output cannot be written");
  }
  // All that was to be done beside printing has been done.
  EXPECT_TRUE(fs::exists(folder_ / "merged.json") && fs::exists(folder_ / "a.csv"));
  for (const char* arguments : {"stillframe-controller --gains run/gains.yaml --check-only",
                                "stillframe-controller --help", "stillframe-plant --help"}) {
    expect_full(here_ + "exec $BIN/" + arguments + " > /dev/full",
                "standard output cannot be written: No space left on device");
  }
}

TEST_F(FullDisk, KeepsItsOwnCodeWhereSomethingElseIsWrong) {
  EXPECT_EQ(shell("exec $BIN/stillframe modes none.yaml > /dev/full").exit_code, 2);
  EXPECT_EQ(shell("exec $BIN/stillframe --help > /dev/null").exit_code, 0);
  // No standard output at all: what is printed does not go into the file that is written.
  const std::string design = here_ + "exec $BIN/stillframe design " + frame_ + " --out ";
  EXPECT_EQ(shell(design + "silent.yaml >&-").exit_code, 1);
  EXPECT_EQ(shell(design + "gains.yaml").exit_code, 0);
  EXPECT_EQ(text_of(folder_ / "silent.yaml"), text_of(folder_ / "gains.yaml"));
}

TEST_F(FullDisk, LeavesTheOlderFileWhole) {
  ASSERT_EQ(shell(here_ + "$BIN/stillframe run " + frame_ +
                  " --mode single_process --loop active --duration 2 --out run")
                .exit_code,
            0);
  const std::string uncertainty =
      " --uncertainty '" + config("uncertainty/piezo_frame.yaml").string() + "'";
  expect_whole_or_older("gains.yaml", "design " + frame_ + " --out gains.yaml", 1);
  expect_whole_or_older("loop.mat", "design " + frame_ + " --mat loop.mat", 1);
  expect_whole_or_older("linear.mat", "linearise " + frame_ + " --mat linear.mat", 1);
  expect_whole_or_older(
      "all.json", "robustness " + frame_ + uncertainty + " --samples 5 --no-search --out all.json",
      1);
  expect_whole_or_older("a.csv", "export run/active.lcm --csv a.csv", 1);
  expect_whole_or_older("a.mat", "export run/active.lcm --mat a.mat", 1);
  expect_whole_or_older("page.html", "report run --out page.html", 1);
  expect_whole_or_older("verdict.json", "report run --out /dev/null --verdict verdict.json", 1);
  expect_full("exec $BIN/stillframe sigma " + frame_ + " --plot /dev/full",
              "/dev/full: cannot be written: No space left on device");
  // gnuplot's script is in a file too, in memory; these pictures are larger.
  expect_whole_or_older("trade.png", "design " + frame_ + " --plot-trade trade.png", 100);
  expect_whole_or_older(
      "spread.png",
      "robustness " + frame_ + uncertainty + " --samples 5 --no-search --plot spread.png", 140);
}

// Rows are whole, those that are there stay, and what is written on goes on from them.
TEST_F(FullDisk, LeavesWholeRowsOfASweep) {
  const std::string sweep =
      "$BIN/stillframe sweep " + frame_ + " --set controller.target_hz=2:20:20 --out rows.jsonl";
  expect_full(here_ + "trap '' XFSZ\nulimit -f 3\nexec " + sweep,
              "rows.jsonl: cannot be written: File too large; the same command goes on from the "
              "rows that it has");
  const std::string rows = text_of(folder_ / "rows.jsonl");
  ASSERT_FALSE(rows.empty());
  EXPECT_EQ(rows.back(), '\n');
  ASSERT_EQ(shell(here_ + "exec " + sweep).exit_code, 0);
  const std::string all = text_of(folder_ / "rows.jsonl");
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 20);
  EXPECT_EQ(all.substr(0, rows.size()), rows);
  // What is endless is not read.
  EXPECT_EQ(shell(here_ + "exec $BIN/stillframe sweep " + frame_ +
                  " --set controller.target_hz=2,3 --out /dev/full")
                .exit_code,
            2);
}

TEST_F(FullDisk, EndsARunThatSaysWhy) {
  const Said said = shell(here_ +
                          "trap '' XFSZ\nulimit -f 100\n"
                          "exec $BIN/stillframe run " +
                          frame_ + " --mode single_process --loop active --duration 2 --out run");
  EXPECT_EQ(said.exit_code, 4);
  const std::string why = "run.incomplete/active.lcm: cannot be written: File too large";
  EXPECT_NE(said.error.find(why), std::string::npos) << said.error;
  EXPECT_FALSE(fs::exists(folder_ / "run"));
  EXPECT_EQ(text_of(folder_ / "run.incomplete/FAILED.txt"), why + "\n");
}

TEST_F(FullDisk, IsSaidByTheFilesOfTheController) {
  EXPECT_THROW(controller::write_timing_file("/dev/full", {}, {}), OutputError);
  const controller::FlightRecorder recorder(10, 1, 0, {}, {});
  EXPECT_THROW(controller::write_flight_file("/dev/full", {}, recorder, ""), OutputError);
}

}  // namespace
}  // namespace stillframe::test
