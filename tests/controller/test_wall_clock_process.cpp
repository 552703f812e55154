#include <sched.h>

#include <csignal>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <thread>

#include "controller/supervisor.hpp"
#include "controller/telemetry.hpp"
#include "core/worst.hpp"
#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "stillframe_msgs/loop_checkpoint_t.hpp"
#include "stillframe_msgs/loop_records_t.hpp"
#include "tests/controller/controller_process.hpp"

namespace stillframe::controller {
namespace {

void publish_at(toy::FakePlant& plant, std::int64_t k, std::int64_t at_ns) {
  sleep_until(at_ns);
  plant.publish(plant.measure(k));
}

/// All that the controller says of itself.
class Listener {
 public:
  explicit Listener(toy::FakePlant& plant) {
    plant.lcm().subscribe(channels::loop, &Listener::on_records, this)->setQueueCapacity(0);
    plant.lcm()
        .subscribe(channels::checkpoint, &Listener::on_checkpoint, this)
        ->setQueueCapacity(0);
    plant.lcm().subscribe(channels::status, &Listener::on_status, this)->setQueueCapacity(0);
  }
  std::vector<LoopRecord> records;
  std::vector<LoopCheckpoint> checkpoints;
  stillframe_msgs::controller_status_t status{};

 private:
  void on_records(const lcm::ReceiveBuffer*, const std::string&,
                  const stillframe_msgs::loop_records_t* message) {
    for (const auto& record : message->records) records.push_back(from_message(record));
  }
  void on_checkpoint(const lcm::ReceiveBuffer*, const std::string&,
                     const stillframe_msgs::loop_checkpoint_t* message) {
    checkpoints.push_back({.period = message->period, .memory = message->memory});
  }
  void on_status(const lcm::ReceiveBuffer*, const std::string&,
                 const stillframe_msgs::controller_status_t* message) {
    status = *message;
  }
};

TEST_F(ControllerProcess, WallClockSaysAllThatItsCommandsCameFrom) {
  constexpr std::int64_t n_samples = 2500;
  const Gains gains = toy::gains(5, 1000, 1);
  toy::FakePlant plant(toy::run_info(gains, 9, "wall_clock", n_samples));
  Listener listener(plant);
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  const std::int64_t start = monotonic_ns() + 20'000'000;
  plant.publish_state(run_state_t::RUNNING, start);
  // Paced by the clock because that is the mode; how well it is kept is not judged here.
  for (std::int64_t k = 0; k < n_samples; ++k) {
    publish_at(plant, k, start + k * 1'000'000);
    while (plant.take(0)) {
    }
    plant.move(plant.commands.empty() ? std::vector<double>(4, 0.0) : plant.commands.back().force);
  }
  plant.publish_state(run_state_t::ENDED);
  while (!plant.timing && plant.take(1000)) {
  }
  EXPECT_EQ(controller.wait(), 0) << controller.err();
  ASSERT_TRUE(plant.timing);
  ASSERT_FALSE(listener.checkpoints.empty());
  ASSERT_FALSE(listener.records.empty());
  EXPECT_EQ(listener.status.n_records_dropped, 0);

  // The supervisor here, given the records one by one, comes to the same commands; and those are
  // what was sent.
  Supervisor supervisor(gains, {}, true);
  ASSERT_EQ(listener.checkpoints.front().period, listener.records.front().period);
  supervisor.restore(listener.checkpoints.front().memory);
  Command command;
  command.force = Eigen::VectorXd::Zero(4);
  size_t sent = 0;
  std::int64_t answered = 0;
  for (const LoopRecord& record : listener.records) {
    const bool have = record.defect == Defect::none;
    const bool send = supervisor.step({.n_elapsed = record.n_elapsed,
                                       .measurement = have ? &record.measurement : nullptr,
                                       .defect = record.defect,
                                       .request = record.request},
                                      command);
    ASSERT_EQ(send, record.sent) << record.period;
    ASSERT_EQ(command.force, record.command.force) << record.period;
    answered += have;
    if (!send) continue;
    ASSERT_LT(sent, plant.commands.size());
    EXPECT_EQ(plant.commands[sent].seq, command.seq);
    ASSERT_EQ(plant.commands[sent].force,
              std::vector<double>(command.force.begin(), command.force.end()));
    ++sent;
  }
  EXPECT_EQ(sent, plant.commands.size());
  EXPECT_GT(sent, 0u);
  EXPECT_EQ(plant.timing->n_lost, n_samples - answered);
  EXPECT_EQ(plant.timing->n_duplicate, 0);
  EXPECT_EQ(plant.timing->n_periods, static_cast<std::int64_t>(listener.records.size()));
  EXPECT_EQ(plant.timing->n_periods + plant.timing->n_late, listener.records.back().period + 1);
}

/// Threads of a process, name and scheduling policy.
std::vector<std::string> ordinary_threads(pid_t pid) {
  std::vector<std::string> ordinary;
  const auto tasks = std::filesystem::path("/proc") / std::to_string(pid) / "task";
  for (const auto& task : std::filesystem::directory_iterator(tasks)) {
    std::string name;
    std::getline(std::ifstream(task.path() / "comm"), name);
    if (sched_getscheduler(std::stoi(task.path().filename())) != SCHED_FIFO) {
      ordinary.push_back(name);
    }
  }
  return ordinary;
}

// Whatever a stop or a measurement comes through must not wait for its turn.
TEST_F(ControllerProcess, OnlyTerminalAndDiskWaitBehindOrdinaryPrograms) {
  const sched_param fifo{.sched_priority = 1};
  if (sched_setscheduler(0, SCHED_FIFO, &fifo) != 0) GTEST_SKIP() << "no right to SCHED_FIFO here";
  const sched_param other{.sched_priority = 0};
  ASSERT_EQ(sched_setscheduler(0, SCHED_OTHER, &other), 0);
  const Gains gains = toy::gains(5, 1000, 1);
  toy::FakePlant plant(toy::run_info(gains, 9, "wall_clock", 1'000'000));
  Listener listener(plant);
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  const std::int64_t start = monotonic_ns();
  plant.publish_state(run_state_t::RUNNING, start);
  for (std::int64_t k = 0; listener.status.n_periods < 200 && k < 10'000; ++k) {
    publish_at(plant, k, start + k * 1'000'000);
    while (plant.take(0)) {
    }
  }
  const std::vector<std::string> ordinary = ordinary_threads(controller.pid());
  EXPECT_EQ(ordinary.size(), 2U) << testing::PrintToString(ordinary);
  plant.publish_state(run_state_t::ENDED);
  controller.wait();
}

/// What ends a controller while the plant goes on measuring.
struct End {
  const char* name;
  int signal = 0;             ///< to the controller, or
  std::int32_t state = 0;     ///< what the plant says of itself, with
  std::int64_t later_ns = 0;  ///< so much added to its start
  int exit_code = 4;
};

class WallClockEnds : public ControllerProcess, public testing::WithParamInterface<End> {};

// The last command is no force at all, and those before it are next to none: 1 % of the largest,
// where the ramp's last is 1e-8 of it. A controller that just ends leaves whatever force there is.
// That the machine takes the processor away makes a fade out of the ramp, which ends in the same
// way.
TEST_P(WallClockEnds, WithARampToNoForce) {
  const Gains gains = toy::gains(5, 1000, 1);
  toy::FakePlant plant(toy::run_info(gains, 9, "wall_clock", 100'000));
  Listener listener(plant);
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  const std::int64_t start = monotonic_ns() + 20'000'000;
  plant.publish_state(run_state_t::RUNNING, start);
  bool told = false;
  double largest = 0;
  std::size_t n_commands = 0;
  std::int64_t heard = 0;
  const auto size = [](const command_t& command) {
    double most = 0;
    for (const double force : command.force) most = worst_of(most, std::abs(force));
    return most;
  };
  // Until no command has come for 0.3 s.
  for (std::int64_t k = 0; !told || k < heard + 300; ++k) {
    publish_at(plant, k, start + k * 1'000'000);
    while (plant.take(0)) {
    }
    if (plant.commands.size() > n_commands) heard = k;
    n_commands = plant.commands.size();
    plant.move(n_commands == 0 ? std::vector<double>(4, 0.0) : plant.commands.back().force);
    if (n_commands > 0) largest = worst_of(largest, size(plant.commands.back()));
    if (told || listener.status.state != stillframe_msgs::controller_status_t::ACTIVE) continue;
    told = true;
    heard = k;
    if (GetParam().signal != 0) {
      controller.signal(GetParam().signal);
    } else {
      plant.publish_state(GetParam().state, start + GetParam().later_ns, "as it is");
    }
  }
  if (GetParam().later_ns != 0)
    controller.signal(SIGTERM);  // it waits for the plant that begins anew
  EXPECT_EQ(controller.wait(), GetParam().exit_code) << controller.err();
  ASSERT_GT(n_commands, 1u);
  EXPECT_GT(largest, 0);
  EXPECT_EQ(size(plant.commands.back()), 0);
  EXPECT_LT(size(plant.commands[n_commands - 2]), 0.01 * largest);
}

INSTANTIATE_TEST_SUITE_P(
    Ends, WallClockEnds,
    testing::Values(
        End{.name = "SIGINT", .signal = SIGINT}, End{.name = "SIGTERM", .signal = SIGTERM},
        End{.name = "SIGHUP", .signal = SIGHUP},
        End{.name = "ENDED", .state = run_state_t::ENDED, .exit_code = 0},
        End{.name = "FAILED", .state = run_state_t::FAILED},
        End{.name = "BeganAnew", .state = run_state_t::RUNNING, .later_ns = 1'000'000'000}),
    [](const auto& end) { return std::string(end.param.name); });

TEST_F(ControllerProcess, WallClockThatWasNeverActiveIsExitCode4) {
  const Gains gains = toy::gains(5, 1000, 1);
  toy::FakePlant plant(toy::run_info(gains, 9, "wall_clock", 100'000));
  Listener listener(plant);
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  const std::int64_t start = monotonic_ns();
  plant.publish_state(run_state_t::RUNNING, start);
  // Every measurement is five periods old when it comes.
  for (std::int64_t k = 0; listener.records.empty() || listener.records.back().period < 4500; ++k) {
    publish_at(plant, k, start + (k + 5) * 1'000'000);
    while (plant.take(0)) {
    }
  }
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 4);
  EXPECT_TRUE(contains(controller.err(), "the loop was never active")) << controller.err();
}

TEST_F(ControllerProcess, WallClockSkipsWhatItSleptThrough) {
  constexpr std::int64_t n_slept = 60, period_ns = 1'000'000;
  const Gains gains = toy::gains(5, 1000, 1);
  toy::FakePlant plant(toy::run_info(gains, 9, "wall_clock", 1000));
  Listener listener(plant);
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  const std::int64_t start = monotonic_ns();
  plant.publish_state(run_state_t::RUNNING, start);
  while (listener.records.empty()) ASSERT_TRUE(plant.take(10'000));
  controller.suspend();
  sleep_until(monotonic_ns() + n_slept * period_ns);
  controller.signal(SIGCONT);
  const auto slept = [](const LoopRecord& record) { return record.n_elapsed >= n_slept; };
  while (std::none_of(listener.records.begin(), listener.records.end(), slept)) {
    ASSERT_TRUE(plant.take(10'000));
  }
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
  while (!plant.timing && plant.take(1000)) {
  }
  ASSERT_TRUE(plant.timing);
  EXPECT_GE(plant.timing->n_late, n_slept - 1);
  EXPECT_GE(plant.timing->worst_wake_up_ns, (n_slept - 1) * period_ns);
  // Every period of the run was either woken for or skipped, and the phase was kept.
  EXPECT_EQ(plant.timing->n_periods + plant.timing->n_late, listener.records.back().period + 1);
  for (const LoopRecord& record : listener.records) {
    EXPECT_EQ((record.deadline_ns - start) % period_ns, period_ns / 2);
  }
}

}  // namespace
}  // namespace stillframe::controller
