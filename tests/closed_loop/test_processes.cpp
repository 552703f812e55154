#include <csignal>
#include <fstream>
#include <lcm/lcm-cpp.hpp>

#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "stillframe_msgs/run_state_t.hpp"
#include "tests/closed_loop/workspace.hpp"

namespace stillframe::test {
namespace {

namespace fs = std::filesystem;

/// A run that would last for minutes, disturbed while it goes on.
class Processes : public Workspace {
 protected:
  std::unique_ptr<tools::ChildProcess> start_long_run() {
    auto process = start({"run", config("scenes/metrology_frame.yaml"), "--duration", "380",
                          "--loop", "active", "--out", folder_ / "run", "--timeout", "2"});
    const auto log = folder_ / "run.incomplete/active.lcm";
    // Until a tenth of a megabyte is logged: the loop is running then.
    const std::int64_t until = monotonic_ns() + 60 * ns_per_s;
    std::error_code error;
    while (!(fs::exists(log) && fs::file_size(log, error) > 100'000) && monotonic_ns() < until) {
      process->wait(0.02);
    }
    return process;
  }

  /// The id of the process of that name in this network.
  pid_t id_of(const std::string& name) const {
    for (const auto& entry : fs::directory_iterator("/proc")) {
      std::error_code error;
      if (fs::read_symlink(entry.path() / "ns/net", error) != fs::read_symlink("/proc/self/ns/net"))
        continue;
      std::ifstream stream(entry.path() / "cmdline");
      std::string command;
      std::getline(stream, command, '\0');
      if (fs::path(command).filename() == name) return std::stoi(entry.path().filename());
    }
    return -1;
  }

  void expect_failed_run(tools::ChildProcess& process, const std::string& reason) {
    const auto code = process.wait(30);
    ASSERT_TRUE(code.has_value()) << "still running";
    EXPECT_EQ(*code, 4);
    EXPECT_FALSE(fs::exists(folder_ / "run"));
    std::ifstream stream(folder_ / "run.incomplete/FAILED.txt");
    const std::string text(std::istreambuf_iterator<char>(stream), {});
    EXPECT_NE(text.find(reason), std::string::npos) << text;
    EXPECT_TRUE(processes_left().empty()) << processes_left().front();
  }
};

TEST_F(Processes, StopCleanlyOnCtrlC) {
  const auto run = start_long_run();
  kill(id_of("stillframe"), SIGINT);
  expect_failed_run(*run, "interrupted");
}

TEST_F(Processes, StopWhenTheControllerDies) {
  const auto run = start_long_run();
  kill(id_of("stillframe-controller"), SIGKILL);
  expect_failed_run(*run, "stillframe-controller ended with code 137");
}

TEST_F(Processes, StopWhenThePlantDies) {
  const auto run = start_long_run();
  kill(id_of("stillframe-plant"), SIGKILL);
  expect_failed_run(*run, "stillframe-plant ended with code 137\n");
}

TEST_F(Processes, StopWhenTheLoggerDies) {
  const auto run = start_long_run();
  kill(id_of("lcm-logger"), SIGKILL);
  expect_failed_run(*run, "lcm-logger ended with code 137");
}

TEST_F(Processes, ALogThatCannotGrowIsNamedWithTheReason) {
  // A limit on the size of a file stops the logger as a full disk does.
  const Said said = shell(
      "cd '" + folder_.string() + "'\ntrap '' XFSZ\nulimit -f 400\nexec $BIN/stillframe run '" +
      config("scenes/metrology_frame.yaml").string() + "' --loop active --duration 10 --out run");
  EXPECT_EQ(said.exit_code, 4);
  EXPECT_NE(said.error.find("(run.incomplete/active.lcm: cannot be written: File too large)"),
            std::string::npos)
      << said.error;
}

TEST_F(Processes, WallClockRunAccountsForEveryPeriod) {
  const Said said =
      run({"run", config("scenes/metrology_frame.yaml"), "--mode", "wall_clock", "--duration", "3",
           "--loop", "active", "--out", folder_ / "run", "--json"});
  // A busy machine may lose samples, which the exit code then says; it must not lose count of them.
  ASSERT_TRUE(said.exit_code == 0 || said.exit_code == 4) << said.error;
  const auto verdict = nlohmann::json::parse(said.output);
  const auto& logged = verdict.at("runs").at(0);
  EXPECT_EQ(logged.at("n_samples").get<int>() + logged.at("n_lost").get<int>(), 3001);
  for (const auto& timing : verdict.at("timing")) {
    if (timing.at("source") == "plant") {
      EXPECT_EQ(timing.at("n_periods"), 3001);
    } else {
      // Answered, lost and listened to, measurements make up the run; duplicates are none.
      EXPECT_LE(logged.at("n_commands").get<int>(), 3001);
      EXPECT_GE(logged.at("n_commands").get<int>() + timing.at("n_lost").get<int>() +
                    timing.at("n_listened").get<int>() + logged.at("n_lost").get<int>(),
                3001);
    }
  }
}

TEST_F(Processes, AMotionThatCannotGoOnEndsTheRunWithTimeStateAndReason) {
  const auto floor = write("floor.yaml", "white: {rms: 1e12, duration_s: 1}\n");
  for (const char* mode : {"lock_step", "single_process"}) {
    const auto out = folder_ / mode;
    const Said said = run({"run", config("scenes/metrology_frame.yaml"), "--floor", floor, "--mode",
                           mode, "--loop", "passive", "--run-id", "3", "--out", out});
    EXPECT_EQ(said.exit_code, 4) << mode;
    EXPECT_NE(said.error.find("plant at t = 0.0"), std::string::npos) << said.error;
    EXPECT_NE(said.error.find(" m from the operating point"), std::string::npos) << said.error;
    // The log says so as well, and holds what there was until then.
    lcm::LogFile log((out.string() + ".incomplete/passive.lcm"), "r");
    ASSERT_TRUE(log.good());
    std::string reason;
    int n_measurements = 0;
    while (const lcm::LogEvent* event = log.readNextEvent()) {
      if (event->channel == channels::measurement) ++n_measurements;
      if (event->channel != channels::run_state) continue;
      stillframe_msgs::run_state_t state;
      ASSERT_GE(state.decode(event->data, 0, event->datalen), 0);
      if (state.state == stillframe_msgs::run_state_t::FAILED) reason = state.text;
    }
    EXPECT_NE(reason.find("plant at t = 0.0"), std::string::npos) << mode << ": " << reason;
    EXPECT_GE(n_measurements, 1) << mode;
  }
}

}  // namespace
}  // namespace stillframe::test
