#include <csignal>
#include <map>
#include <mutex>

#include "tests/live/bus_plant.hpp"
#include "tests/live/http_client.hpp"
#include "tests/tools/verb.hpp"

namespace stillframe::live {
namespace {

using Json = nlohmann::json;
using test::Said;

/// Whatever is on the bus, by channel.
class Eavesdropper {
 public:
  Eavesdropper() : lcm_(open_lcm(lcm_url(""))) {
    lcm_->subscribe(".*", &Eavesdropper::on_message, this);
    thread_ = std::jthread([this](const std::stop_token& stop) {
      while (!stop.stop_requested()) handle_one(*lcm_, 20);
    });
  }
  std::map<std::string, int> heard() {
    const std::lock_guard lock(mutex_);
    return heard_;
  }

 private:
  void on_message(const lcm::ReceiveBuffer*, const std::string& channel) {
    const std::lock_guard lock(mutex_);
    ++heard_[channel];
  }
  std::unique_ptr<lcm::LCM> lcm_;
  std::mutex mutex_;
  std::map<std::string, int> heard_;
  std::jthread thread_;
};

class WatchVerb : public test::Verb {
 protected:
  std::vector<Json> lines(const std::vector<std::string>& arguments) {
    const Said said = run(arguments);
    EXPECT_EQ(said.exit_code, 0) << said.error;
    EXPECT_EQ(said.error, "");
    std::vector<Json> list;
    std::istringstream stream(said.output);
    for (std::string line; std::getline(stream, line);) list.push_back(Json::parse(line));
    return list;
  }

  /// The first line that a process prints, once it has.
  static std::string first_line(tools::ChildProcess& process) {
    for (;;) {
      const auto lines = process.read_lines();
      if (!lines.empty()) return lines.front();
      if (process.exit_code()) return "";
      process.wait(0.02);
    }
  }

  static int port_in(const std::string& line) {
    const auto at = line.find("127.0.0.1:");
    return at == std::string::npos ? 0 : std::stoi(line.substr(at + 10));
  }
};

TEST_F(WatchVerb, SeesARunThatBeganBefore) {
  sample::BusPlant plant(7, 31'000, true);
  const auto document = lines({"watch", "--json", "--once", "--duration", "4"});
  ASSERT_EQ(document.size(), 1u);
  const Json& view = document[0];
  EXPECT_EQ(view["run"]["run_id"], "7");
  EXPECT_EQ(view["run"]["names"], "run_info");
  EXPECT_GE(view["run"]["seq"], 31'000 + 1000);
  EXPECT_EQ(view["controller"]["state"], "active");
  ASSERT_EQ(view["axes"].size(), 1u);
  // The closed form of the sine; the window is not a whole number of its periods.
  EXPECT_NEAR(view["axes"][0]["floor"]["rms_m_s2"].get<double>(),
              sample::floor_amplitude / std::sqrt(2), 0.01 * sample::floor_amplitude);
  EXPECT_EQ(view["legs"][1]["peak_n"], 50);
  for (const auto& channel : view["channels"]) {
    EXPECT_EQ(channel["n_broken"], 0) << channel;
    EXPECT_EQ(channel["n_other_version"], 0) << channel;
    EXPECT_EQ(channel["n_wrong_size"], 0) << channel;
  }
  expect_documented_keys("watch", view);
}

TEST_F(WatchVerb, PrintsALineASecond) {
  sample::BusPlant plant(7, 0, true);
  const auto views = lines({"watch", "--json", "--duration", "3.5"});
  ASSERT_EQ(views.size(), 4u);  // after 1, 2, 3 and 3.5 s
  EXPECT_GT(views.back()["run"]["seq"], views.front()["run"]["seq"]);
}

TEST_F(WatchVerb, ASceneNamesWhatIsNotDescribed) {
  // The legs, floor and outputs of the sample.
  const auto scene = write("scene.yaml", R"(title: A sample
nodes:
  floor: {position: [0, 0, 0]}
  mass: {position: [0, 0, 1]}
  other: {position: [0, 0, -1]}
masses:
  - {node: mass, mass: 2}
elements:
  leg_a: {type: truss, nodes: [floor, mass], stiffness: 800}
  leg_b: {type: truss, nodes: [other, mass], stiffness: 800}
supports:
  - {nodes: [mass, floor, other], fix: [x, y]}
prescribed:
  - {nodes: [floor, other], move: [z]}
dofs:
  - {element: leg_a}
inputs:
  - {name: floor_z, acceleration: floor, along: z}
outputs:
  - {name: mass_z, acceleration: mass, along: z}
monitors:
  - {name: below_z, acceleration: floor, along: z}
compare:
  vertical: {floor: below_z, frame: mass_z}
controller:
  legs: [leg_a, leg_b]
  target_hz: 1
  damping_ratio: 0.7
  sample_rate_hz: 1000
  delay_samples: 1
  leak_hz: 0.05
  force_limit_n: 100
)");
  sample::BusPlant plant(7, 31'000, false);
  const auto numbered = lines({"watch", "--json", "--once", "--duration", "3"});
  ASSERT_EQ(numbered.size(), 1u);
  EXPECT_EQ(numbered[0]["run"]["names"], "numbers");
  EXPECT_EQ(numbered[0]["compared"], false);
  EXPECT_EQ(numbered[0]["axes"].size(), 3u);
  EXPECT_EQ(numbered[0]["run"]["sample_rate_hz"], 1000);
  const auto named = lines({"watch", "--json", "--once", "--duration", "3", "--scene", scene});
  ASSERT_EQ(named.size(), 1u);
  EXPECT_EQ(named[0]["run"]["names"], "scene");
  EXPECT_EQ(named[0]["axes"][0]["axis"], "vertical");
  EXPECT_EQ(named[0]["legs"][1]["leg"], "leg_b");
  EXPECT_EQ(named[0]["legs"][1]["share"], 0.5);
}

TEST_F(WatchVerb, ATextWithoutATerminalIsPlain) {
  sample::BusPlant plant(7, 0, true);
  const Said said = run({"watch", "--once"});
  EXPECT_EQ(said.exit_code, 0) << said.error;
  EXPECT_EQ(said.output.find('\033'), std::string::npos);
  EXPECT_TRUE(said.output.starts_with("stillframe watch   A sample   run 7")) << said.output;
  EXPECT_NE(said.output.find("SF_MEASUREMENT"), std::string::npos);
}

/// Attached and detached ten times over, it adds nothing to what the run itself says but liblcm's
/// own test of the network.
TEST_F(WatchVerb, PublishesNothing) {
  Eavesdropper ear;
  for (int i = 0; i < 3; ++i) run({"watch", "--once", "--duration", "0.3"});
  {
    sample::BusPlant plant(7, 0, true);
    for (int i = 0; i < 3; ++i) run({"watch", "--json", "--duration", "0.3"});
  }
  for (const auto& [channel, n] : ear.heard()) {
    const bool of_the_run = channel == "SF_MEASUREMENT" || channel == "SF_COMMAND" ||
                            channel == "SF_RUN_INFO" || channel == "SF_RUN_STATE" ||
                            channel == "SF_STATUS" || channel == "SF_LOOP";
    EXPECT_TRUE(of_the_run || channel == "LCM_SELF_TEST") << channel << " " << n;
  }
}

TEST_F(WatchVerb, ServesThePageAndEndsAtCtrlC) {
  sample::BusPlant plant(7, 0, true);
  const auto process = start({"watch", "--serve", "0"});
  const int port = port_in(first_line(*process));
  ASSERT_GT(port, 0);
  Connection browser(port);
  browser.send("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const std::string events = browser.read_until("\"run_id\":\"7\"");
  EXPECT_NE(events.find("data: {\"format\":2"), std::string::npos);
  Connection hanging(port);
  hanging.send("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  while (get(port, "/view").find("vibration_class") == std::string::npos) usleep(50'000);
  process->stop();
  EXPECT_EQ(process->exit_code(), 0);
  const std::string all = browser.read_all();
  EXPECT_EQ(all.substr(all.size() - 5), "0\r\n\r\n");
  EXPECT_FALSE(Connection(port).open());
}

TEST_F(WatchVerb, NothingHeardIsExitCode4) {
  const Said said = run({"watch", "--once", "--duration", "0.5"});
  EXPECT_EQ(said.exit_code, 4);
  EXPECT_NE(said.error.find("nothing heard on udpm://"), std::string::npos) << said.error;
}

/// Where a process may open few files it says so, whichever of its parts is the first to lack one.
TEST_F(WatchVerb, FewDescriptorsAreAnErrorAndNoCrash) {
  bool refused = false, served = false;
  for (int n = 3; n <= 24; ++n) {
    const Said said = shell("ulimit -n " + std::to_string(n) +
                            "; exec $BIN/stillframe watch --serve 0 --duration 0.1");
    // 4: it was as well as it can be and heard nothing; 127: not even the libraries could be read.
    EXPECT_TRUE(said.exit_code == 2 || said.exit_code == 4 || said.exit_code == 127)
        << n << " files: " << said.exit_code << " " << said.error;
    refused |= said.exit_code == 2;
    served |= said.exit_code == 4;
  }
  EXPECT_TRUE(refused);
  EXPECT_TRUE(served);
}

TEST_F(WatchVerb, BadUsageIsExitCode2) {
  expect_refused({"watch", "--lcm-url", "nonsense://"}, 2, "LCM cannot be opened");
  expect_refused({"watch", "--scene", folder_ / "none.yaml"}, 2, "none.yaml: cannot be read");
  EXPECT_EQ(run({"watch", "--serve", "65536"}).exit_code, 2);
  EXPECT_EQ(run({"watch", "--duration", "0"}).exit_code, 2);
  EXPECT_EQ(run({"watch", "scene.yaml"}).exit_code, 2);
  const auto first = start({"watch", "--serve", "0"});
  const int port = port_in(first_line(*first));
  ASSERT_GT(port, 0);
  expect_refused({"watch", "--serve", std::to_string(port)}, 2, "another program may have it");
}

}  // namespace
}  // namespace stillframe::live
