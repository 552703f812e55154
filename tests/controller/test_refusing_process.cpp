#include <csignal>

#include "msgs/clock.hpp"
#include "tests/controller/controller_process.hpp"

namespace stillframe::controller {
namespace {

TEST_F(ControllerProcess, NaivePiIsRefused) {
  Gains gains = toy::gains(5);
  gains.realisation = Realisation::naive_pi;
  for (const auto& more : {std::vector<std::string>{}, {"--check-only"}}) {
    ChildProcess controller(command_line(gains, more));
    EXPECT_EQ(controller.wait(), 3);
    EXPECT_TRUE(contains(controller.err(), "realisation: implicit_feedthrough"))
        << controller.err();
    EXPECT_EQ(controller.out(), "");
  }
}

struct BadNumber {
  const char* name;
  std::string line;  // of the toy gains' YAML, its beginning
  std::string instead;
  int exit_code;
  const char* says;
};

// Each of these once ran, crashed, or took all memory. A plant without its hash is judged as it is.
TEST_F(ControllerProcess, AbsurdGainsAreRefusedInOneSentence) {
  const std::vector<BadNumber> bad{
      {"leak", "leak_hz:", "leak_hz: 1e308", 2, "leak_hz: found '1e308'"},
      {"rate", "sample_rate_hz:", "sample_rate_hz: 1e-300", 2, "sample_rate_hz: found '1e-300'"},
      {"K_I", "  - [339.", "  - [1e308, 0, 0, 0]", 2, "K_I[1][1]: found '1e308'"},
      {"delay_3e9", "delay_samples:", "delay_samples: 3e9", 2, "delay_samples: found '3e9'"},
      {"delay_1e4", "delay_samples:", "delay_samples: 1e4", 2, "delay_samples: found '1e4'"},
      {"delay_100", "delay_samples:", "delay_samples: 100", 2, "delay_samples: found '100'"},
      {"alias", "legs:", "legs: &a [*a]", 2, "legs: found an anchor or alias"},
      {"plant", "    - [0, 0, 0, 0, 1, 0, 0, 0]", "    - [1000000, 0, 0, 0, 1, 0, 0, 0]", 2,
       "plant.hash: found"},
      {"plant_of_their_own", "    - [0, 0, 0, 0, 1, 0, 0, 0]",
       "    - [1000000, 0, 0, 0, 1, 0, 0, 0]", 3, "not stable"}};
  for (const BadNumber& number : bad) {
    SCOPED_TRACE(number.name);
    const auto arguments = command_line(toy::gains(5), {"--check-only"});
    std::string text = to_yaml(toy::gains(5));
    const auto replace_line = [&](const std::string& line, const std::string& instead) {
      const std::size_t at = text.find("\n" + line) + 1;
      ASSERT_NE(at, 0u);
      text.replace(at, text.find('\n', at) - at, instead);
    };
    replace_line(number.line, number.instead);
    if (number.exit_code == 3) replace_line("  hash:", "");
    std::ofstream(gains_file) << text;
    ChildProcess controller(arguments);
    EXPECT_EQ(controller.wait(), number.exit_code);
    EXPECT_TRUE(contains(controller.err(), number.says)) << controller.err();
    EXPECT_EQ(controller.out(), "");
  }
}

TEST_F(ControllerProcess, CheckOnlyPrintsTheRadius) {
  ChildProcess controller(command_line(toy::gains(5), {"--check-only"}));
  EXPECT_EQ(controller.wait(), 0) << controller.err();
  EXPECT_TRUE(contains(controller.out(), "spectral radius 0.9999")) << controller.out();
  EXPECT_FALSE(contains(controller.err(), "has no hash")) << controller.err();
}

TEST_F(ControllerProcess, APlantThatNobodyVouchesForIsToldOf) {
  const auto arguments = command_line(toy::gains(5), {"--check-only"});
  std::string text = to_yaml(toy::gains(5));
  const std::size_t at = text.find("\n  hash:");
  ASSERT_NE(at, std::string::npos);
  text.erase(at, text.find('\n', at + 1) - at);
  std::ofstream(gains_file) << text;
  ChildProcess controller(arguments);
  EXPECT_EQ(controller.wait(), 0);
  EXPECT_TRUE(contains(controller.err(), "plant: has no hash")) << controller.err();
}

TEST_F(ControllerProcess, DisagreementIsToldToThePlantAndExits2) {
  auto info = toy::run_info(toy::gains(5), 1, "lock_step", 1);
  info.scene_hash = "another";
  toy::FakePlant plant(info);
  ChildProcess controller(command_line(toy::gains(5)));
  ASSERT_EQ(plant.announce(), run_state_t::FAILED);
  EXPECT_TRUE(contains(plant.states.back().text, "scene_hash"));
  EXPECT_EQ(controller.wait(), 2);
  EXPECT_TRUE(contains(controller.err(), "scene_hash")) << controller.err();
}

// Before a plant is heard, which then is not kept waiting.
TEST_F(ControllerProcess, APolicyTooShortForASlowLoopIsRefused) {
  std::ofstream(folder / "policy.yaml") << "measurements: {fade_s: 0.1}\n";
  // The frame's modes are far above this rate; the target is at a twentieth of it.
  Gains gains = toy::gains(0.5, 10);
  ChildProcess controller(command_line(gains, {"--policy", folder / "policy.yaml"}));
  EXPECT_EQ(controller.wait(), 2);
  EXPECT_TRUE(contains(controller.err(),
                       "measurements.fade_s: found '0.1', allowed at 10 Hz is a "
                       "number from 1 on, 10 samples"))
      << controller.err();
}

// Lock-step runs go without, as do those whose policy has one.
TEST_F(ControllerProcess, WallClockWithoutForceLimitIsToldToThePlantAndExits3) {
  Gains gains = toy::gains(5);
  gains.force_limit_n.reset();
  const auto begin = [](toy::FakePlant& plant) {
    ASSERT_EQ(plant.announce(), run_state_t::READY);
    plant.publish_state(run_state_t::RUNNING, monotonic_ns());
  };
  for (const std::string loop : {"active", "passive"}) {
    SCOPED_TRACE(loop);
    auto info = toy::run_info(gains, 1, "wall_clock", 100);
    info.loop = loop;
    toy::FakePlant plant(info);
    ChildProcess controller(command_line(gains));
    begin(plant);
    EXPECT_EQ(controller.wait(), 3);
    EXPECT_TRUE(contains(controller.err(), "refused: no force limit")) << controller.err();
    while (plant.states.back().state != run_state_t::FAILED && plant.take(1000)) {
    }
    EXPECT_EQ(plant.states.back().state, run_state_t::FAILED);
    EXPECT_TRUE(contains(plant.states.back().text, "no force limit"));
  }
  std::ofstream(folder / "policy.yaml") << "limits: {force_n: 100}\n";
  toy::FakePlant plant(toy::run_info(gains, 1, "wall_clock", 100));
  ChildProcess controller(command_line(gains, {"--policy", folder / "policy.yaml"}));
  begin(plant);
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
}

TEST_F(ControllerProcess, WallClockWithoutDelayExits2) {
  const Gains gains = toy::gains(5, 1000, 0);
  toy::FakePlant plant(toy::run_info(gains, 1, "wall_clock", 1));
  ChildProcess controller(command_line(gains));
  EXPECT_EQ(plant.announce(), run_state_t::FAILED);
  EXPECT_EQ(controller.wait(), 2);
  EXPECT_TRUE(contains(controller.err(), "delay_samples")) << controller.err();
}

TEST_F(ControllerProcess, SilenceExits4) {
  {
    ChildProcess controller(command_line(toy::gains(5), {"--timeout", "0.2"}));
    EXPECT_EQ(controller.wait(), 4);
    EXPECT_TRUE(contains(controller.err(), "nothing heard")) << controller.err();
  }
  for (const std::string mode : {"lock_step", "wall_clock"}) {
    toy::FakePlant plant(toy::run_info(toy::gains(5), 1, mode, 100));
    ChildProcess controller(command_line(toy::gains(5), {"--timeout", "1"}));
    ASSERT_EQ(plant.announce(), run_state_t::READY);
    plant.publish_state(run_state_t::RUNNING, monotonic_ns());
    if (mode == "lock_step") {
      ASSERT_TRUE(plant.exchange(plant.measure(0)));
    }
    EXPECT_EQ(controller.wait(), 4);
    EXPECT_TRUE(contains(controller.err(), "nothing heard")) << controller.err();
  }
}

TEST_F(ControllerProcess, PlantFailureExits4WithItsReason) {
  for (const bool running : {false, true}) {
    toy::FakePlant plant(toy::run_info(toy::gains(5), 1, "lock_step", 100));
    ChildProcess controller(command_line(toy::gains(5)));
    ASSERT_EQ(plant.announce(), run_state_t::READY);
    if (running) {
      plant.publish_state(run_state_t::RUNNING);
      ASSERT_TRUE(plant.exchange(plant.measure(0)));
    }
    plant.publish_state(run_state_t::FAILED, 0, "the integrator gave up");
    EXPECT_EQ(controller.wait(), 4);
    EXPECT_TRUE(contains(controller.err(), "the integrator gave up")) << controller.err();
  }
}

TEST_F(ControllerProcess, SignalsStopItAndThePlantIsTold) {
  for (const int signal : {SIGINT, SIGTERM}) {
    for (const std::string mode : {"lock_step", "wall_clock"}) {
      toy::FakePlant plant(toy::run_info(toy::gains(5), 1, mode, 100));
      ChildProcess controller(command_line(toy::gains(5)));
      ASSERT_EQ(plant.announce(), run_state_t::READY);
      plant.publish_state(run_state_t::RUNNING, monotonic_ns());
      if (mode == "lock_step") {
        ASSERT_TRUE(plant.exchange(plant.measure(0)));
      }
      controller.signal(signal);
      EXPECT_EQ(controller.wait(), 4);
      while (plant.states.back().state != run_state_t::FAILED && plant.take(1000)) {
      }
      EXPECT_EQ(plant.states.back().state, run_state_t::FAILED);
    }
  }
}

TEST_F(ControllerProcess, BadCommandLinesExit2) {
  const std::vector<std::vector<std::string>> bad{
      {program},
      {program, "--gains", "no/such/file.yaml"},
      {program, "--gains", gains_file, "--no-such-option"},
      command_line(toy::gains(5), {"--timeout", "-1"}),
      command_line(toy::gains(5), {"--phase", "1.5"}),
      command_line(toy::gains(5), {"--lcm-url", "nonsense://"})};
  for (const auto& arguments : bad) {
    ChildProcess controller(arguments);
    EXPECT_EQ(controller.wait(), 2) << arguments.back();
    EXPECT_NE(controller.err(), "") << arguments.back();
  }
}

TEST_F(ControllerProcess, WithoutMulticastItSaysWhatMends) {
  auto arguments = command_line(toy::gains(5), {"--timeout", "1"});
  arguments.insert(arguments.begin(), {"unshare", "--net"});
  ChildProcess controller(arguments);
  EXPECT_EQ(controller.wait(), 2);
  EXPECT_TRUE(contains(controller.err(), "ip route add 224.0.0.0/4 dev lo")) << controller.err();
}

TEST_F(ControllerProcess, HelpTeaches) {
  ChildProcess controller({program, "--help"});
  EXPECT_EQ(controller.wait(), 0);
  for (const char* part : {"--gains", "--check-only", "--realtime", "Exit codes", "SF_COMMAND"}) {
    EXPECT_TRUE(contains(controller.out(), part)) << part;
  }
}

}  // namespace
}  // namespace stillframe::controller
