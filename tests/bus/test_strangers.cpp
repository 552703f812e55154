// Real processes by the clock, and what else may be on their bus: recordings, a second plant, a
// stranger that sends what no LCM would send.
#include <sys/resource.h>

#include <atomic>
#include <thread>

#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/control_request_t.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"
#include "tests/bus/hostile.hpp"
#include "tests/closed_loop/workspace.hpp"
#include "tests/support/quarantine.hpp"

namespace stillframe::test {
namespace {

class Strangers : public Workspace {
 protected:
  void SetUp() override {
    Workspace::SetUp();
    const Said said = run({"design", config("scenes/metrology_frame.yaml"), "--out", gains()});
    ASSERT_EQ(said.exit_code, 0) << said.error;
  }
  std::string gains() const { return (folder_ / "gains.yaml").string(); }

  /// A plant of run 7 and a controller in the background of a shell, passive
  /// because it is not asked here what the loop does on a busy machine: their codes go to the files
  /// NAME.plant and NAME.controller, what they say to NAME.txt.
  std::string loop(const std::string& name) const {
    const std::string scene = config("scenes/metrology_frame.yaml").string();
    return here() + "(\"$BIN\"/stillframe-plant " + scene + " --gains " + gains() +
           " --mode wall_clock --loop passive --run-id 7 --duration 3 >> " + name +
           ".txt 2>&1; echo $? > " + name + ".plant) & plant=$!\n" +
           "(\"$BIN\"/stillframe-controller --gains " + gains() + " --run-id 7 >> " + name +
           ".txt 2>&1; echo $? > " + name + ".controller) & controller=$!\n";
  }
  /// What a controller remembers of faults stays in the folder of the test.
  std::string here() const {
    return "cd " + folder_.string() + "\nexport XDG_STATE_HOME=" + folder_.string() + "\n";
  }
  int code(const std::string& file) const {
    const std::string text = text_of(folder_ / file);
    return text.empty() ? -1 : std::stoi(text);
  }
};

// What an lcm-logger wrote of a run, a stop among it, steers no run of the same number.
TEST_F(Strangers, AReplayedLogSteersNothing) {
  const std::string play = "lcm-logplayer old.lcm > /dev/null 2>&1 & player=$!\n";
  const Said first =
      shell(here() +
            "lcm-logger --quiet --force --flush-interval=1 old.lcm > /dev/null 2>&1 & logger=$!\n" +
            loop("first") +
            "\"$BIN\"/stillframe ctl stop --timeout 60 > stop.txt 2>&1; echo $?\n"
            "wait $plant $controller; kill $logger; wait");
  ASSERT_EQ(first.output, "0\n") << text_of(folder_ / "stop.txt");
  ASSERT_EQ(code("first.plant"), 0) << text_of(folder_ / "first.txt");
  // Nothing is there to hear but the recording: it is no controller, and no plant.
  const Said nobody = shell(here() + play +
                            "\"$BIN\"/stillframe ctl status --timeout 3; status=$?\n"
                            "\"$BIN\"/stillframe-controller --gains " +
                            gains() + " --timeout 2; echo $status $?; kill $player; wait");
  EXPECT_EQ(nobody.output, "4 4\n") << nobody.error;
  EXPECT_NE(nobody.error.find("nothing heard from the plant"), std::string::npos) << nobody.error;
  shell(here() + play + loop("second") + "wait $plant $controller; kill $player; wait");
  const std::string said = text_of(folder_ / "second.txt");
  EXPECT_EQ(code("second.plant"), 0) << said;
  EXPECT_EQ(code("second.controller"), 0) << said;
  EXPECT_EQ(said.find("another"), std::string::npos) << said;
}

TEST_F(Strangers, ASecondPlantOfTheSameNumberGoes) {
  const std::string second = "\"$BIN\"/stillframe-plant " +
                             config("scenes/metrology_frame.yaml").string() + " --gains " +
                             gains() + " --mode wall_clock --run-id 7 2>&1";
  const Said said = shell(
      loop("first") +
      "until grep -q \"real time\" first.txt; do kill -0 $plant || exit 9; done\n" +  // it runs
      second + "; echo $?\nwait");
  EXPECT_TRUE(said.output.ends_with("\n3\n")) << said.output;
  EXPECT_NE(said.output.find("another plant runs as run 7"), std::string::npos) << said.output;
  const std::string first = text_of(folder_ / "first.txt");
  EXPECT_EQ(code("first.plant"), 0) << first;
  EXPECT_EQ(code("first.controller"), 0) << first;
  EXPECT_EQ(first.find("anew"), std::string::npos) << first;
}

/// Claims of sizes that would take gigabytes, of this run and of another one.
void send_claims(const HostileSender& sender) {
  using namespace stillframe_msgs;
  for (const std::int64_t run_id : {7, 8}) {
    for (const std::uint32_t n : {1u << 26, 1u << 29, ~0u}) {
      command_t command{};
      measurement_t measurement{};
      run_info_t info{};
      loop_records_t records{};
      command.run_id = measurement.run_id = info.run_id = records.run_id = run_id;
      sender.send(whole_datagram("SF_COMMAND", huge_claim(command, 56, n)));
      sender.send(whole_datagram("SF_MEASUREMENT", huge_claim(measurement, 48, n)));
      // Behind eight texts of no letters: 8 + 2 * 8 + 4 + 8 * 5 + 3 * 8.
      sender.send(whole_datagram("SF_RUN_INFO", huge_claim(info, 92, n)));
      sender.send(whole_datagram("SF_LOOP", huge_claim(records, 24, n)));
    }
  }
}

// From before they are started until after they have ended.
TEST_F(Strangers, NoPacketKillsAProcessOrFillsItsMemory) {
  std::atomic<bool> done = false;
  std::jthread stranger([&done] {
    HostileSender sender;
    while (!done) {
      sender.send_hostile(50);
      send_claims(sender);
      std::this_thread::yield();
    }
  });
  const Said said = shell(loop("run") +
                          "\"$BIN\"/stillframe watch --duration 2 > watch.txt 2>&1; echo $?\n"
                          "\"$BIN\"/stillframe ctl status --timeout 20 > ctl.txt 2>&1; echo $?\n"
                          "wait");
  done = true;
  // What gets through drowns measurements, so the run may fail; nobody may die of it.
  EXPECT_EQ(said.output.substr(0, 2), "0\n") << text_of(folder_ / "watch.txt");
  for (const char* file : {"run.plant", "run.controller"}) {
    EXPECT_TRUE(code(file) == 0 || code(file) == 4) << file << ": " << code(file) << "\n"
                                                    << text_of(folder_ / "run.txt");
  }
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  // Forty times what the largest of them takes otherwise is less than any of the claims.
  EXPECT_LT(usage.ru_maxrss, 400'000 + test::quarantine_bytes / 1024) << "kB";
}

}  // namespace
}  // namespace stillframe::test
