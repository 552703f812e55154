// The controller program against a fake plant, over LCM. Run through scripts/private_network.

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <fstream>
#include <limits>
#include <set>

#include "controller/answer.hpp"
#include "controller/clock.hpp"
#include "controller/lcm_io.hpp"
#include "msgs/channels.hpp"
#include "tests/support/allocation_count.hpp"
#include "tests/controller/child_process.hpp"
#include "tests/controller/fake_plant.hpp"
#include "tests/controller/toy_plant.hpp"

namespace stillframe::controller {
namespace {

using stillframe_msgs::command_t;
using stillframe_msgs::measurement_t;
using stillframe_msgs::run_state_t;
using test::ChildProcess;

const std::string program = std::string(STILLFRAME_BIN_DIR) + "/stillframe-controller";

class ControllerProcess : public testing::Test {
 protected:
  ControllerProcess() {
    static int n = 0;
    gains_file = testing::TempDir() + "stillframe_gains_" + std::to_string(getpid()) + "_" +
                 std::to_string(++n) + ".yaml";
  }
  ~ControllerProcess() override { unlink(gains_file.c_str()); }

  /// Writes the gains and gives the command line to run them.
  std::vector<std::string> command_line(const Gains& gains, std::vector<std::string> more = {}) {
    std::ofstream(gains_file) << to_yaml(gains);
    std::vector<std::string> all{program, "--gains", gains_file};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  std::string gains_file;
};

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// The bytes that the law, run here, would send.
class Reference {
 public:
  explicit Reference(const Gains& gains)
      : answer_(law_from_gains(gains), gains.force_limit_n, true) {
    answer_.prepare(command_);
  }
  std::vector<std::uint8_t> operator()(const measurement_t& measurement) {
    answer_.answer(measurement, command_);
    std::vector<std::uint8_t> bytes(static_cast<size_t>(command_.getEncodedSize()));
    command_.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    return bytes;
  }

 private:
  Answer answer_;
  command_t command_{};
};

void publish_at(toy::FakePlant& plant, std::int64_t k, std::int64_t at_ns) {
  const timespec deadline{.tv_sec = at_ns / ns_per_s, .tv_nsec = at_ns % ns_per_s};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr);
  plant.publish(plant.measure(k));
}

TEST_F(ControllerProcess, LockStepAnswersToTheBitAndInOrder) {
  constexpr std::int64_t n_samples = 2000;
  Gains gains = toy::gains(5, 1000, 0);
  gains.force_limit_n = 0.005;  // reached in the first swings, then no more
  toy::FakePlant plant(toy::run_info(gains, 42, "lock_step", n_samples));
  ChildProcess controller(command_line(gains, {"--run-id", "42"}));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  plant.publish_state(run_state_t::RUNNING);
  Reference reference(gains);
  int n_saturated = 0;
  for (std::int64_t k = 0; k < n_samples; ++k) {
    const measurement_t measurement = plant.measure(k);
    const auto command = plant.exchange(measurement);
    ASSERT_TRUE(command) << "no answer to " << k;
    ASSERT_EQ(plant.command_bytes.back(), reference(measurement)) << "sample " << k;
    n_saturated += command->saturated;
    plant.move(command->force);
  }
  EXPECT_GT(n_saturated, 0);
  EXPECT_LT(n_saturated, n_samples / 2);
  ASSERT_EQ(plant.commands.size(), static_cast<size_t>(n_samples));
  for (std::int64_t k = 0; k < n_samples; ++k) {
    ASSERT_EQ(plant.commands[static_cast<size_t>(k)].seq, k);
  }
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
  EXPECT_TRUE(contains(controller.out(), "controller: 2000 periods, 0 late, 0 lost, worst wake-up"))
      << controller.out();
  while (!plant.timing && plant.take(1000)) {
  }
  ASSERT_TRUE(plant.timing);
  EXPECT_EQ(plant.timing->run_id, 42);
  EXPECT_EQ(plant.timing->n_periods, n_samples);
  EXPECT_EQ(plant.timing->n_duplicate, 0);
  EXPECT_EQ(plant.timing->worst_wake_up_ns, 0);
  EXPECT_GT(plant.timing->worst_compute_ns, 0);
  EXPECT_GT(plant.timing->wall_time_ns, 0);
}

TEST_F(ControllerProcess, AMeasurementHeardAgainIsAnsweredWithTheSameBytes) {
  const Gains gains = toy::gains(5);
  toy::FakePlant plant(toy::run_info(gains, 1, "lock_step", 3));
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  plant.publish_state(run_state_t::RUNNING);
  Reference reference(gains);
  for (std::int64_t k = 0; k < 3; ++k) {
    const measurement_t measurement = plant.measure(k);
    const auto expected = reference(measurement);
    for (int again = 0; again < 3; ++again) {
      plant.commands.clear();
      ASSERT_TRUE(plant.exchange(measurement));
      EXPECT_EQ(plant.command_bytes.back(), expected);
    }
  }
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
  EXPECT_TRUE(contains(controller.out(), "controller: 3 periods, 0 late, 0 lost"));
  while (!plant.timing && plant.take(1000)) {
  }
  ASSERT_TRUE(plant.timing);
  EXPECT_EQ(plant.timing->n_duplicate, 6);
}

TEST_F(ControllerProcess, ForeignAndDamagedMessagesAreIgnored) {
  const Gains gains = toy::gains(5);
  toy::FakePlant plant(toy::run_info(gains, 1, "lock_step", 3));
  ChildProcess controller(command_line(gains, {"--run-id", "1"}));
  toy::FakePlant other(toy::run_info(toy::gains(2), 2, "lock_step", 3));
  // The other run is always announced first: the controller must still take the one it was started
  // for.
  for (int attempt = 0; attempt < 500 && plant.states.empty(); ++attempt) {
    other.lcm().publish(channels::run_info, &other.info());
    plant.lcm().publish(channels::run_info, &plant.info());
    plant.take(20);
  }
  ASSERT_FALSE(plant.states.empty());
  ASSERT_EQ(plant.states.front().run_id, 1);
  plant.publish_state(run_state_t::RUNNING);
  Reference reference(gains);
  ASSERT_TRUE(plant.exchange(plant.measure(0)));
  EXPECT_EQ(plant.command_bytes.back(), reference(plant.measure(0)));
  const size_t n_before = plant.commands.size();
  other.publish(other.measure(1));
  other.publish_state(run_state_t::ENDED);
  measurement_t short_one = plant.measure(1);
  short_one.n_legs = 3;
  plant.publish(short_one);
  std::vector<std::uint8_t> bytes(static_cast<size_t>(plant.measure(1).getEncodedSize()));
  plant.measure(1).encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  plant.publish_raw(channels::measurement, bytes.data(), 10);
  auto huge = bytes;  // claims 2^31 - 1 legs
  std::memcpy(huge.data() + 36, "\x7f\xff\xff\xff", 4);
  plant.publish_raw(channels::measurement, huge.data(), huge.size());
  auto negative = bytes;  // and -1 floor inputs
  std::memcpy(negative.data() + 32, "\xff\xff\xff\xff", 4);
  plant.publish_raw(channels::measurement, negative.data(), negative.size());
  plant.publish_raw(channels::run_state, bytes.data(), bytes.size());
  for (std::int64_t k = 1; k < 3; ++k) {
    ASSERT_TRUE(plant.exchange(plant.measure(k)));
    EXPECT_EQ(plant.command_bytes.back(), reference(plant.measure(k)));
  }
  EXPECT_EQ(plant.commands.size(), n_before + 2);
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
}

TEST_F(ControllerProcess, PassiveLoopCommandsZero) {
  const Gains gains = toy::gains(5);
  auto info = toy::run_info(gains, 1, "lock_step", 2);
  info.loop = "passive";
  toy::FakePlant plant(info);
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  plant.publish_state(run_state_t::RUNNING);
  for (std::int64_t k = 0; k < 2; ++k) {
    const auto command = plant.exchange(plant.measure(k));
    ASSERT_TRUE(command);
    EXPECT_EQ(command->force, std::vector<double>(4, 0.0));
  }
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
}

TEST_F(ControllerProcess, NonFiniteMeasurementFallsBackAndExits4) {
  const Gains gains = toy::gains(5);
  toy::FakePlant plant(toy::run_info(gains, 1, "lock_step", 1));
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  plant.publish_state(run_state_t::RUNNING);
  measurement_t measurement = plant.measure(0);
  measurement.sigma[1] = std::numeric_limits<double>::quiet_NaN();
  const auto command = plant.exchange(measurement);
  ASSERT_TRUE(command);
  EXPECT_EQ(command->force, std::vector<double>(4, 0.0));
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 4);
  EXPECT_TRUE(contains(controller.err(), "1 commands fell back to zero force")) << controller.err();
}

TEST_F(ControllerProcess, WallClockAnswersTheNewestAndCountsTheRest) {
  constexpr std::int64_t n_samples = 300;
  const Gains gains = toy::gains(5, 1000, 1);
  toy::FakePlant plant(toy::run_info(gains, 9, "wall_clock", n_samples));
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  const std::int64_t start = monotonic_ns() + 20'000'000;
  plant.publish_state(run_state_t::RUNNING, start);
  // Paced by the clock because that is the mode; how well it is kept is not judged here.
  for (std::int64_t k = 0; k < n_samples; ++k) {
    publish_at(plant, k, start + k * 1'000'000);
    plant.move({1e-3, 0, -1e-3, 0});
  }
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
  while (!plant.timing && plant.take(1000)) {
  }
  ASSERT_TRUE(plant.timing);
  // The same measurements again: every answer must be the law's, run over those that were answered.
  toy::FakePlant again(plant.info());
  Reference reference(gains);
  size_t answered = 0;
  for (std::int64_t k = 0; k < n_samples && answered < plant.commands.size(); ++k) {
    const measurement_t measurement = again.measure(k);
    again.move({1e-3, 0, -1e-3, 0});
    if (plant.commands[answered].seq != k) continue;
    ASSERT_EQ(plant.command_bytes[answered], reference(measurement)) << "sample " << k;
    ++answered;
  }
  EXPECT_EQ(answered, plant.commands.size());
  EXPECT_GT(answered, 0u);
  EXPECT_EQ(plant.timing->n_lost, n_samples - static_cast<std::int64_t>(answered));
  EXPECT_EQ(plant.timing->n_duplicate, 0);
  // Wake-ups and skipped periods together are the run, and the period in which the end is heard.
  EXPECT_GE(plant.timing->n_periods + plant.timing->n_late, n_samples);
}

TEST_F(ControllerProcess, WallClockSkipsWhatItSleptThrough) {
  constexpr std::int64_t n_samples = 60, period_ns = 1'000'000;
  const Gains gains = toy::gains(5, 1000, 1);
  toy::FakePlant plant(toy::run_info(gains, 9, "wall_clock", n_samples));
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  const std::int64_t start = monotonic_ns();
  plant.publish_state(run_state_t::RUNNING, start);
  ASSERT_TRUE(plant.exchange(plant.measure(0)));
  controller.suspend();
  const std::int64_t suspended = monotonic_ns();
  for (std::int64_t k = 1; k < n_samples; ++k) publish_at(plant, k, suspended + k * period_ns);
  controller.signal(SIGCONT);
  while (plant.commands.back().seq != n_samples - 1) ASSERT_TRUE(plant.take(5000));
  // One answer, to the newest; a few more if LCM's reading thread was itself slow to catch up.
  EXPECT_LT(plant.commands.size(), 20u);
  plant.publish_state(run_state_t::ENDED);
  const std::int64_t told = monotonic_ns();
  EXPECT_EQ(controller.wait(), 0) << controller.err();
  const std::int64_t ended = monotonic_ns();
  while (!plant.timing && plant.take(1000)) {
  }
  ASSERT_TRUE(plant.timing);
  const auto answered =
      static_cast<std::int64_t>(plant.commands.size()) - plant.timing->n_duplicate;
  EXPECT_EQ(plant.timing->n_lost, n_samples - answered);
  EXPECT_GE(plant.timing->worst_wake_up_ns, (n_samples - 2) * period_ns);
  // Every period of the run was either woken for or skipped; the ends are uncertain by one each.
  const std::int64_t periods = plant.timing->n_periods + plant.timing->n_late;
  EXPECT_GE(periods, (told - start) / period_ns - 1);
  EXPECT_LE(periods, (ended - start) / period_ns + 1);
}

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

TEST_F(ControllerProcess, CheckOnlyPrintsTheRadius) {
  ChildProcess controller(command_line(toy::gains(5), {"--check-only"}));
  EXPECT_EQ(controller.wait(), 0) << controller.err();
  EXPECT_TRUE(contains(controller.out(), "spectral radius 0.9999")) << controller.out();
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
    ASSERT_TRUE(plant.exchange(plant.measure(0)));
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
      ASSERT_TRUE(plant.exchange(plant.measure(0)));
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

// Taking a measurement, answering and publishing allocates nothing of its own; what liblcm does
// inside its shared library is not counted.
TEST(LcmIo, SteadyStateDoesNotAllocate) {
  const Gains gains = toy::gains(5);
  toy::FakePlant plant(toy::run_info(gains, 1, "lock_step", 100));
  LcmIo io("");
  io.follow(plant.info());
  Answer answer(law_from_gains(gains), {}, true);
  std::int64_t allocated = 0;
  int heard = 0;
  for (std::int64_t k = 0; k < 20; ++k) {
    plant.publish(plant.measure(k));
    const auto before = test::allocation_count();
    for (int attempt = 0; attempt < 50; ++attempt) {
      if (!io.take(100).measurement) continue;
      answer.answer(io.measurement(), io.command());
      io.publish_command();
      ++heard;
      break;
    }
    allocated += test::allocation_count() - before;
  }
  EXPECT_EQ(heard, 20);
  EXPECT_EQ(allocated, 0);
}

}  // namespace
}  // namespace stillframe::controller
