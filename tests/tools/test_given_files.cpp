#include <regex>

#include "tests/report/sample_log.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::test {
namespace {

namespace fs = std::filesystem;

/// What a verb writes beside what it reads, all of it named on its command line.
class GivenFiles : public Verb {
 protected:
  void SetUp() override {
    Verb::SetUp();
    // Refused before it is read.
    write("a", "what is read");
    write("b", "what is read as well");
  }

  void expect_refused_here(const std::string& arguments, const std::string& message) const {
    const Said said = shell("cd '" + folder_.string() + "'\nexec $BIN/stillframe " + arguments);
    EXPECT_EQ(said.exit_code, 2) << arguments;
    EXPECT_EQ(said.output, "") << arguments;
    EXPECT_EQ(said.error, "stillframe: error: " + message + "\n") << arguments;
    EXPECT_EQ(text_of(folder_ / "a"), "what is read") << arguments;
    EXPECT_EQ(text_of(folder_ / "b"), "what is read as well") << arguments;
  }

  /// A log that can be read.
  void write_log(const std::string& name) const {
    report::LogWriter log(folder_ / name);
    report::write_run(log, 1, 20);
  }
};

TEST_F(GivenFiles, NothingIsWrittenOverWhatIsRead) {
  expect_refused_here("report a --out a", "--out: a is the log that is read");
  expect_refused_here("report a b --out page.html --verdict b",
                      "--verdict: b is the log that is read");
  expect_refused_here("export a --csv a", "--csv: a is the log that is read");
  expect_refused_here("export a --csv c --mat a", "--mat: a is the log that is read");
  expect_refused_here("linearise a --mat a", "--mat: a is the scene that is read");
  expect_refused_here("sigma a --plot a", "--plot: a is the scene that is read");
  expect_refused_here("sigma a --controller b --plot b",
                      "--plot: b is the controller block that is read");
  for (const std::string option : {"--out", "--mat", "--plot-trade"}) {
    expect_refused_here("design a " + option + " a", option + ": a is the scene that is read");
    expect_refused_here("design a --controller b " + option + " b",
                        option + ": b is the controller block that is read");
  }
  expect_refused_here("design a --design-scene b --out b",
                      "--out: b is the design scene that is read");
  expect_refused_here("robustness a --out a", "--out: a is the scene that is read");
  expect_refused_here("robustness a --uncertainty b --plot b",
                      "--plot: b is the uncertainty block that is read");
  expect_refused_here("robustness a --from b --plot b", "--plot: b is the record that is read");
  expect_refused_here("merge a b --out b", "--out: b is a record that is read");
}

TEST_F(GivenFiles, AReportThatIsNamedAfterItsLogDoesNotReplaceIt) {
  write_log("log.html");
  const std::string before = text_of(folder_ / "log.html");
  expect_refused_here("report log.html",
                      "the report without --out: log.html is the log that is read");
  EXPECT_EQ(text_of(folder_ / "log.html"), before);
  // A folder stands for the logs in it.
  fs::create_directory(folder_ / "run");
  fs::rename(folder_ / "log.html", folder_ / "run/active.lcm");
  expect_refused_here("report run --verdict run/active.lcm",
                      "--verdict: run/active.lcm is the log that is read");
  EXPECT_EQ(text_of(folder_ / "run/active.lcm"), before);
}

TEST_F(GivenFiles, AnotherNameOfAFileIsTheFile) {
  fs::create_symlink("a", folder_ / "link");
  fs::create_directory_symlink(".", folder_ / "here");
  for (const std::string name : {"./a", "link", "here/a", "here/./a", "$PWD/a"}) {
    const std::string shown =
        name.starts_with("$PWD") ? (folder_ / "a").string() : name;  // by the shell
    expect_refused_here("linearise a --mat " + name,
                        "--mat: " + shown + " is the scene that is read");
    expect_refused_here("linearise " + name + " --mat a", "--mat: a is the scene that is read");
  }
}

TEST_F(GivenFiles, TwoThatAreWrittenAreTwoFiles) {
  fs::create_directory(folder_ / "d");
  fs::create_directory_symlink("d", folder_ / "link");
  expect_refused_here("report a --out d/x --verdict d/x",
                      "--verdict and --out are one file, d/x; allowed are two");
  expect_refused_here("report a --verdict a.html",
                      "--verdict and the report without --out are one file, a.html; allowed are "
                      "two");
  expect_refused_here("export a --csv y --mat y",
                      "--mat and --csv are one file, y; allowed are two");
  expect_refused_here("design a --out z --mat m --plot-trade z",
                      "--plot-trade and --out are one file, z; allowed are two");
  expect_refused_here("robustness a --out z --plot z",
                      "--plot and --out are one file, z; allowed are two");
  // Of names that are nowhere yet, and of one that is there.
  for (const std::string name : {"./y", "d/../y", "link/../y", "$PWD/y"}) {
    const std::string shown = name.starts_with("$PWD") ? (folder_ / "y").string() : name;
    expect_refused_here("export a --csv y --mat " + name,
                        "--mat and --csv are one file, " + shown + "; allowed are two");
  }
  expect_refused_here("export a --csv d/y --mat link/y",
                      "--mat and --csv are one file, link/y; allowed are two");
  write("y", "an older file");
  expect_refused_here("export a --csv ./y --mat y",
                      "--mat and --csv are one file, y; allowed are two");
  EXPECT_EQ(text_of(folder_ / "y"), "an older file");
}

/// Before minutes of computing or measuring.
TEST_F(GivenFiles, AFolderThatIsNotThereIsSaidFirst) {
  fs::create_directory(folder_ / "d");
  for (const std::string command : {"report a --out",
                                    "report a --out x --verdict",
                                    "export a --csv",
                                    "export a --mat",
                                    "linearise a --mat",
                                    "sigma a --plot",
                                    "design a --out",
                                    "design a --mat",
                                    "design a --plot-trade",
                                    "feedback a --plot",
                                    "feedback a --h2",
                                    "feedback a --minimax",
                                    "robustness a --out",
                                    "robustness a --plot",
                                    "budget a --plot",
                                    "merge a b --out",
                                    "sweep a --set x=1 --out",
                                    "batch a --out",
                                    "rig a --io simulation --out",
                                    "superelement a --interface i=j --out"}) {
    const std::string option = command.substr(command.rfind("--"));
    expect_refused_here(command + " nowhere/x",
                        option + ": found 'nowhere/x', but there is no folder 'nowhere'");
    expect_refused_here(command + " d",
                        option + ": found 'd', which is a folder; allowed is the name of a file");
    expect_refused_here(command + " b/x", option + ": found 'b/x', but there is no folder 'b'");
  }
}

/// Commissioning reads its scene first, for the names of its files and what is left to doubt.
TEST_F(GivenFiles, CommissionRefusesBeforeItMoves) {
  write("frame.yaml", std::regex_replace(text_of(config("scenes/lens_frame.yaml")),
                                         std::regex("\\.\\./"), config("").string()));
  const auto says = [&](const std::string& arguments, const std::string& message) {
    const Said said =
        shell("cd '" + folder_.string() + "'\nexec $BIN/stillframe commission " + arguments);
    EXPECT_EQ(said.exit_code, 2) << arguments;
    EXPECT_EQ(said.output, "") << arguments;
    EXPECT_TRUE(said.error.starts_with("stillframe: error: " + message)) << said.error;
    EXPECT_EQ(said.error.find('\n'), said.error.size() - 1) << said.error;
    EXPECT_FALSE(fs::exists(folder_ / "frame.updated.yaml"));
  };
  const std::string scene = "frame.yaml --io simulation ";
  for (const std::string option : {"--report", "--plot"}) {
    says(scene + option + " nowhere/x.html",
         option + ": found 'nowhere/x.html', but there is no folder 'nowhere'");
  }
  says("frame.yaml --io nodriver", "--io: found 'nodriver', allowed are simulation, device");
  says("frame.yaml", "no driver: name one in a rig file or with --io, or play with --simulate");
  write("rig.yaml", "driver: {name: simulation}\nframe:\n  nobody: {channel: 0}\n");
  says("frame.yaml rig.yaml",
       "rig.yaml:3:11: frame.nobody: is no output of the scene; allowed are ");
  write("known.yaml", "# nothing\nstiffness: 0\n");
  says(scene + "--uncertainty known.yaml",
       "known.yaml:2:1: uncertainty: nothing of this scene is uncertain");
  write("known.yaml", "leg_direction_rad: 30\n");
  says(scene + "--uncertainty known.yaml",
       "known.yaml:1:20: leg_direction_rad: found '30', allowed is a number from 0 to 1");
  // In what is given, seconds.
  says(scene + "--window 0.001", "--window: found 0.001 s at 5000 Hz, which has ");
  says(scene + "--window 5000", "--window: found 5000 s at 5000 Hz, allowed is up to 200 s");
  says(scene + "--window 100 --windows 100",
       "--window, --windows: found 100 of 100 s, a recording of ");
}

TEST_F(GivenFiles, DevicesAndPipesTakeSeveral) {
  write_log("log.lcm");
  for (const std::string place : {"/dev/null", "/dev/stdout"}) {
    const Said said = shell("exec $BIN/stillframe report '" + (folder_ / "log.lcm").string() +
                            "' --out " + place + " --verdict " + place);
    EXPECT_TRUE(said.exit_code == 0 || said.exit_code == 4) << place << said.error;
    EXPECT_EQ(said.output.find("<!DOCTYPE html>") != std::string::npos, place == "/dev/stdout");
  }
}

TEST_F(GivenFiles, AnEmptyNameIsBadUsage) {
  for (const std::string arguments :
       {"report a --out", "report a --out x --verdict", "export a --csv", "linearise a --mat",
        "sigma a --plot", "design a --out", "robustness a --out", "merge a --out"}) {
    const std::string option = arguments.substr(arguments.rfind("--"));
    expect_refused_here(arguments + " ''", option + ": found '', allowed is the name of a file");
  }
}

}  // namespace
}  // namespace stillframe::test
