#include <csignal>
#include <regex>
#include <thread>

#include "tests/controller/controller_process.hpp"

namespace stillframe::controller {
namespace {

const std::string bin = std::string(STILLFRAME_BIN_DIR) + "/";

class RigProcess : public ControllerProcess {
 protected:
  std::string rig(const std::string& more = "", const std::string& name = "rig.yaml") {
    const std::string file = folder / name;
    std::ofstream(file) << "title: a rig\ndriver: {name: device, from: samples, to: commands}\n"
                        << more;
    return file;
  }
  /// One rig file of one driver.
  std::string driver(const std::string& block) {
    static int n = 0;
    const std::string file = folder / (std::to_string(++n) + "driver.yaml");
    std::ofstream(file) << "driver: " << block << "\n";
    return file;
  }
  /// The legs at 0.01 N a count, as the converter has it.
  std::string counts(const char* key, const std::vector<std::string>& legs,
                     const std::vector<int>& channels = {0, 1, 2, 3}, double first = 1) const {
    std::string text = std::string(key) + ":\n";
    for (std::size_t i = 0; i < legs.size(); ++i) {
      text += "  " + legs[i] + ": {channel: " + std::to_string(channels[i]) +
              ", gain: " + std::to_string(i == 0 ? 0.01 * first : 0.01) + "}\n";
    }
    return text;
  }
  ChildProcess converter(std::vector<std::string> more) {
    std::vector<std::string> all{bin + "converter", gains_file, folder / "samples",
                                 folder / "commands"};
    all.insert(all.end(), more.begin(), more.end());
    return ChildProcess(all, plant_priority);
  }
  /// What the closing line counts.
  static int counted(const std::string& out, const std::string& what) {
    std::smatch match;
    return std::regex_search(out, match, std::regex("(\\d+) " + what)) ? std::stoi(match[1]) : -1;
  }
  static Gains of_a_rig() {
    Gains gains = toy::damped_gains();
    gains.force_limit_n = 100;
    return gains;
  }
};

TEST_F(RigProcess, ASimulatedOneRunsWithoutAPlant) {
  // A loop that slept through ten periods arms anew, and three seconds are too few for that.
  for (int left = 2; left >= 0; --left) {
    ChildProcess controller(command_line(of_a_rig(), {"--io", "simulation", "--duration", "3"}));
    const int exit_code = controller.wait();
    if (left > 0 && contains(controller.err(), "fault: suspended")) continue;
    EXPECT_EQ(exit_code, 0) << controller.err();
    EXPECT_TRUE(contains(controller.err(), "info: active")) << controller.err();
    EXPECT_GE(counted(controller.out(), "periods"), 2500);
    break;
  }
}

TEST_F(RigProcess, EndsAtASignalWithoutDuration) {
  ChildProcess controller(command_line(of_a_rig(), {"--io", "simulation"}));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  controller.signal(SIGTERM);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
  EXPECT_TRUE(contains(controller.err(), "ramp_out")) << controller.err();
}

TEST_F(RigProcess, ADriverOfOnesOwnIsLoaded) {
  const std::string library = bin + "../examples/06_rig/libown_driver.so";
  ChildProcess controller(command_line(of_a_rig(), {"--io", library, "--duration", "2"}));
  controller.wait();
  // Legs that ring by themselves are no frame: what counts is that its samples were taken.
  EXPECT_GE(counted(controller.out(), "periods"), 1500) << controller.err();
  EXPECT_TRUE(contains(controller.err(), "driver " + library)) << controller.err();
}

/// Templates of drivers, without their devices: one message, which names what is not there.
class RigTemplates : public RigProcess {
 protected:
  void says(const std::string& driver, const std::string& options, const std::string& what) {
    const std::string library = bin + "../examples/06_rig/lib" + driver + ".so";
    const std::string file = folder / "rig.yaml";
    std::ofstream(file) << "driver: {name: " << library << ", " << options << "}\n";
    ChildProcess controller(command_line(of_a_rig(), {"--rig", file}));
    EXPECT_EQ(controller.wait(), 2) << controller.err();
    const std::string said = controller.err();
    EXPECT_EQ(said.find("error: "), said.rfind("error: ")) << said;
    EXPECT_TRUE(contains(said, what)) << said;
  }
};

#ifdef STILLFRAME_HAS_iio_driver
TEST_F(RigTemplates, OfIioNamesTheDeviceThatIsNotThere) {
  says("iio_driver", "idle: 0, adc: nowhere, dac: nowhere", "libiio_driver.so: IIO");
  says("iio_driver", "adc: nowhere, dac: nowhere", "idle: missing");
}
#endif

#ifdef STILLFRAME_HAS_comedi_driver
TEST_F(RigTemplates, OfComediNamesTheDeviceThatIsNotThere) {
  says("comedi_driver", "idle: 32768, device: /dev/no_comedi",
       "libcomedi_driver.so: /dev/no_comedi: No such file");
  says("comedi_driver", "idle: up, device: /dev/no_comedi",
       "idle: found 'up', allowed is a list of 1");
}
#endif

/// A fast crystal, jitter and gaps, 16 bits: active to the end, no fault, what the log holds is
/// what the converters sent.
TEST_F(RigProcess, ConvertersBehindDevices) {
  const Gains gains = of_a_rig();
  const std::string log = folder / "rig.lcm";
  const std::string file = rig(counts("sigma", gains.legs) + counts("applied", gains.legs) +
                               counts("force", gains.legs));
  const auto line = command_line(gains, {"--rig", file, "--duration", "6"});
  struct Said {
    std::string out, err, cards;
  };
  const auto run = [&] {
    ChildProcess logger({"lcm-logger", "-q", "-f", log});
    ChildProcess cards({bin + "converter", gains_file, folder / "samples", folder / "commands",
                        "duration=8", "ppm=150", "jitter_us=100", "gap_every=500"},
                       plant_priority);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    ChildProcess controller(line);
    EXPECT_EQ(controller.wait(), 0) << controller.err();
    EXPECT_EQ(cards.wait(), 0) << cards.err();
    logger.signal(SIGTERM);
    logger.wait();
    return Said{controller.out(), controller.err(), cards.out()};
  };
  // A loop that slept through ten periods has let go, as it must: of a machine that takes the
  // processor from real-time threads nothing else is learnt.
  Said said = run();
  for (int again = 0; again < 2 && contains(said.err, "fault: suspended"); ++again) said = run();
  EXPECT_TRUE(contains(said.err, "info: active")) << said.err;
  EXPECT_TRUE(contains(said.err, "ramp_out")) << said.err;
  // A machine that stalls loses what it sleeps through, periods of 1 ms, and some at each end; of
  // 6000 samples 36 are not sent. Where it stalls little, nothing looks like a step.
  const int n_late = counted(said.out, "late");
  const std::string worst = "worst wake-up ";
  const size_t at = said.out.find(worst);
  ASSERT_NE(at, std::string::npos) << said.out;
  const int longest = 2 + static_cast<int>(std::stod(said.out.substr(at + worst.size())) / 1000);
  EXPECT_LE(counted(said.out, "lost"), 36 + 40 + longest * n_late) << said.out;
  if (n_late < 100) EXPECT_FALSE(contains(said.err, "stepped")) << said.err;
  EXPECT_TRUE(contains(said.cards, "enabled") && !contains(said.cards, "never")) << said.cards;
}

/// A cable, a sign, a restart: never a larger force on the frame than the passive frame's, but for
/// a half.
TEST_F(RigProcess, WhatIsWrongWithItDrivesNothing) {
  const Gains gains = of_a_rig();
  const std::string legs =
      counts("sigma", gains.legs) + counts("applied", gains.legs) + counts("force", gains.legs);
  const auto largest = [&](std::vector<std::string> fault, const std::string& file) {
    auto line = command_line(gains, {"--rig", file, "--duration", "3.5"});
    std::vector<std::string> all{bin + "converter",   gains_file,   folder / "samples",
                                 folder / "commands", "duration=4", "floor_rms=0.1"};
    all.insert(all.end(), fault.begin(), fault.end());
    ChildProcess cards(all, plant_priority);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    ChildProcess controller(line);
    controller.wait();
    EXPECT_EQ(cards.wait(), 0) << cards.err();
    std::filesystem::remove(folder / "latch.yaml");
    std::smatch match;
    const std::string out = cards.out();
    EXPECT_TRUE(std::regex_search(out, match, std::regex("by ([0-9.e+-]+) N"))) << out;
    return std::stod(match[1]);
  };
  const std::string file = rig(legs);
  // Passive: a rig file of an amplifier that is not connected.
  std::ofstream(folder / "passive.yaml") << "start: on_request\n";
  const double passive = [&] {
    auto line = command_line(
        gains, {"--rig", file, "--duration", "3.5", "--policy", folder / "passive.yaml"});
    ChildProcess cards({bin + "converter", gains_file, folder / "samples", folder / "commands",
                        "duration=4", "floor_rms=0.1"},
                       plant_priority);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    ChildProcess controller(line);
    controller.wait();
    cards.wait();
    const std::string out = cards.out();
    std::smatch match;
    EXPECT_TRUE(std::regex_search(out, match, std::regex("by ([0-9.e+-]+) N"))) << out;
    return std::stod(match[1]);
  }();
  EXPECT_LT(largest({}, file), 1.1 * passive);
  EXPECT_LT(largest({"swap=yes"}, file), 1.5 * passive);
  EXPECT_LT(largest({"flip=yes"}, file), 1.5 * passive);
  EXPECT_LT(largest({"pause_at=2"}, file), 1.5 * passive);
}

TEST_F(RigProcess, BadInputIsOneMessage) {
  struct Case {
    std::vector<std::string> more;
    std::string says;
  };
  const Gains gains = of_a_rig();
  for (const auto& [more, says] : std::vector<Case>{
           {{"--io", "simulated"},
            "error: --io: found 'simulated', allowed are simulation, device and the path of a"},
           {{"--io", "./no.so"}, "error: --io: ./no.so: cannot open"},
           {{"--io", "device"}, "error: --io: from: missing"},
           {{"--rig", "nowhere.yaml"}, "error: nowhere.yaml: cannot be read: No such file"},
           {{"--rig", rig("sigma: {other: {}}\n", "other.yaml")},
            "other.yaml:3:16: sigma.other: is no leg of the gains"},
           {{"--rig", rig("")},
            "rig.yaml:2:30: driver.from: '" + (folder / "samples").string() +
                "' cannot be opened: No such file"},
           {{"--rig", driver("{name: nodriver}")}, "driver.yaml:1:9: driver: found 'nodriver'"},
           {{"--rig", driver("{name: simulation, floor_rms: 1 mm}")},
            "driver.yaml:1:39: driver.floor_rms: found '1 mm', allowed is a number from 0 to"},
           {{"--io", "simulation", "--timing", folder / "nowhere/x.json"},
            "error: --timing: found '" + (folder / "nowhere/x.json").string() +
                "', but there is no folder '" + (folder / "nowhere").string() + "'"},
       }) {
    ChildProcess controller(command_line(gains, more));
    EXPECT_EQ(controller.wait(), 2) << says;
    const std::string said = controller.err();
    EXPECT_TRUE(contains(said, says)) << said;
    EXPECT_EQ(said.find("error: "), said.rfind("error: ")) << said;
    EXPECT_EQ(controller.out(), "");
  }
}

}  // namespace
}  // namespace stillframe::controller
