#include <sched.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <thread>

#include "controller/supervisor.hpp"
#include "controller/telemetry.hpp"
#include "core/numerics/worst.hpp"
#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/identity.hpp"
#include "stillframe_msgs/excitation_t.hpp"
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
    plant.lcm()
        .subscribe(channels::excitation, &Listener::on_excitation, this)
        ->setQueueCapacity(0);
  }
  std::vector<stillframe_msgs::excitation_t> excitations;
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
  void on_excitation(const lcm::ReceiveBuffer*, const std::string&,
                     const stillframe_msgs::excitation_t* message) {
    excitations.push_back(*message);
  }
  void on_status(const lcm::ReceiveBuffer*, const std::string&,
                 const stillframe_msgs::controller_status_t* message) {
    status = *message;
  }
};

TEST_F(ControllerProcess, WallClockSaysAllThatItsCommandsCameFrom) {
  constexpr std::int64_t n_samples = 2500;
  const Gains gains = toy::gains(5, 1000, 1);
  const std::string policy_text =
      "excitation: {kind: multisine, force_n: 0.01, window_s: 0.1, windows: 1, lines: 5}\n";
  std::ofstream(folder / "policy.yaml") << policy_text;
  toy::FakePlant plant(toy::run_info(gains, 9, "wall_clock", n_samples));
  Listener listener(plant);
  ChildProcess controller(command_line(gains, {"--policy", folder / "policy.yaml"}));
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
  Supervisor supervisor(gains, parse_policy(policy_text, "", 1000), true);
  ASSERT_EQ(listener.checkpoints.front().period, listener.records.front().period);
  supervisor.restore(listener.checkpoints.front().memory);
  Command command;
  command.force = Eigen::VectorXd::Zero(4);
  size_t sent = 0, excited = 0;
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
    if (supervisor.excited().isZero(0)) continue;
    ASSERT_LT(excited, listener.excitations.size());
    const auto& said = listener.excitations[excited++];
    EXPECT_EQ(said.seq, command.seq);
    EXPECT_EQ(said.force,
              std::vector<double>(supervisor.excited().begin(), supervisor.excited().end()));
  }
  EXPECT_EQ(excited, listener.excitations.size());
  if (listener.status.n_faults == 0) EXPECT_GT(excited, 100u);
  EXPECT_EQ(sent, plant.commands.size());
  EXPECT_GT(sent, 0u);
  EXPECT_EQ(plant.timing->n_lost, n_samples - answered);
  EXPECT_EQ(plant.timing->n_duplicate, 0);
  EXPECT_EQ(plant.timing->n_periods, static_cast<std::int64_t>(listener.records.size()));
  EXPECT_EQ(plant.timing->n_periods + plant.timing->n_late, listener.records.back().period + 1);
}

/// A plant on another host. From a moment on its samples come later: because their way takes
/// longer, which is lateness and stays it, or because its clock has stood still, which is followed.
TEST_F(ControllerProcess, WallClockTellsALongerWayFromAClockThatStoodStill) {
  constexpr std::int64_t period = 5'000'000, later = 300'000'000;
  const Gains gains = toy::gains(5, 200, 1);
  for (const bool stood_still : {false, true}) {
    auto info = toy::run_info(gains, 9, "wall_clock", 100'000);
    info.plant_instance += std::int64_t{1} << bits_below_clock;
    toy::FakePlant plant(info);
    plant.ahead_ns = 40'000 * ns_per_s;
    Listener listener(plant);
    ChildProcess controller(command_line(gains));
    ASSERT_EQ(plant.announce(), run_state_t::READY);
    const std::int64_t start = monotonic_ns() + 20'000'000;
    const std::int64_t said = start + plant.ahead_ns;
    std::int64_t shift = 0;
    for (std::int64_t k = 0; k < 800; ++k) {
      if (k % 50 == 0) plant.publish_state(run_state_t::RUNNING, said);
      if (k == 400) {
        shift = later;
        if (stood_still) plant.ahead_ns -= later;
      }
      publish_at(plant, k, start + k * period + shift);
      while (plant.take(0)) {
      }
      plant.move(plant.commands.empty() ? std::vector<double>(4, 0.0)
                                        : plant.commands.back().force);
    }
    plant.publish_state(run_state_t::ENDED);
    controller.wait();
    const std::string told = controller.err();
    EXPECT_NE(told.find("the samples come late"), std::string::npos) << told;
    EXPECT_EQ(told.find("come at another time") != std::string::npos, stood_still) << told;
  }
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

class WallClockEnds : public ControllerProcess, public testing::WithParamInterface<End> {
 protected:
  /// Once more, up to six times in all, where this program was late.
  void ends_with_a_ramp();
  int n_late_ = 0;
};

/// The largest change of a force from one command to the next, a sample.
double steepest(const std::vector<command_t>& commands, std::size_t begin, std::size_t end) {
  double most = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const command_t &before = commands[i - 1], &now = commands[i];
    const auto n = static_cast<double>(std::max<std::int64_t>(now.seq - before.seq, 1));
    for (std::size_t leg = 0; leg < now.force.size(); ++leg) {
      most = worst_of(most, std::abs(now.force[leg] - before.force[leg]) / n);
    }
  }
  return most;
}

double size(const command_t& command) {
  double most = 0;
  for (const double force : command.force) most = worst_of(most, std::abs(force));
  return most;
}

// On a floor that keeps the force up. Where the machine takes the processor away a fade of the same
// shape takes the ramp's place, for as long as itself.
void WallClockEnds::ends_with_a_ramp() {
  constexpr double floor_hz = 2, floor_mps2 = 0.002, rate_hz = 1000;
  const Gains gains = toy::gains(5, rate_hz, 1);
  const Policy policy;
  toy::FakePlant plant(toy::run_info(gains, 9, "wall_clock", 100'000));
  Listener listener(plant);
  ChildProcess controller(command_line(gains));
  ASSERT_EQ(plant.announce(), run_state_t::READY);
  const std::int64_t start = monotonic_ns() + 20'000'000;
  plant.publish_state(run_state_t::RUNNING, start);
  bool told = false;
  double largest = 0;
  std::size_t n_commands = 0, n_active = 0, n_told = 0;  // that were heard until then
  std::int64_t heard = 0, heard_ns = 0, latest_ns = 0;
  // Until no command has come for 0.3 s, by the samples and by the clock: a plant that catches up
  // sends hundreds in a moment.
  constexpr std::int64_t quiet_ns = 300'000'000;
  for (std::int64_t k = 0; !told || k < heard + 300 || monotonic_ns() < heard_ns + quiet_ns; ++k) {
    ASSERT_TRUE(told || k < 30'000) << "never active";
    publish_at(plant, k, start + k * 1'000'000);
    if (told) latest_ns = std::max(latest_ns, monotonic_ns() - (start + k * 1'000'000));
    while (plant.take(0)) {
    }
    if (plant.commands.size() > n_commands) {
      heard = k;
      heard_ns = monotonic_ns();
    }
    n_commands = plant.commands.size();
    plant.move(n_commands == 0 ? std::vector<double>(4, 0.0) : plant.commands.back().force,
               floor_mps2 * std::sin(two_pi * floor_hz / rate_hz * static_cast<double>(k)));
    if (told || listener.status.state != stillframe_msgs::controller_status_t::ACTIVE) continue;
    if (n_active == 0) n_active = n_commands;
    const double now = size(plant.commands.back());
    largest = worst_of(largest, now);
    // After a period of the floor, and where a force that is dropped makes a step.
    if (static_cast<double>(n_commands - n_active) < rate_hz / floor_hz || now < largest / 2) {
      continue;
    }
    told = true;
    heard = k;
    heard_ns = monotonic_ns();
    n_told = n_commands;
    if (GetParam().signal != 0) {
      controller.signal(GetParam().signal);
    } else {
      plant.publish_state(GetParam().state, start + GetParam().later_ns, "as it is");
    }
  }
  // It waits for the plant that begins anew.
  if (GetParam().later_ns != 0) controller.signal(SIGTERM);
  EXPECT_EQ(controller.wait(), GetParam().exit_code) << controller.err();
  // A frame that this program moves late, by several samples at once, swings for itself.
  if (latest_ns > 3'000'000 && ++n_late_ < 6) return ends_with_a_ramp();

  // s(p) U changes by s' U + s U', s' being 15/8 a ramp at the most, U' what the law itself changes
  // while it is active: twice that, because the frame swings otherwise on its way out. Seen 0.42 to
  // 0.64 of it, and 27 times of it where the force is dropped.
  const double ramp = 15.0 / 8 * largest / (policy.ramp_out_s * rate_hz);
  EXPECT_LT(steepest(plant.commands, n_told, n_commands),
            2 * (ramp + steepest(plant.commands, n_active, n_told)));
  EXPECT_EQ(size(plant.commands.back()), 0);

  const auto end = listener.records.end();
  const auto stop = std::find_if(listener.records.begin(), end,
                                 [](const auto& r) { return r.request == Request::stop; });
  const auto zero =
      std::find_if(stop, end, [](const auto& r) { return r.sent && r.command.force.isZero(0); });
  ASSERT_NE(zero, end);
  const double lasted_s = static_cast<double>(zero->period - stop->period) / rate_hz;
  // To the sample; a period without a measurement holds the gain.
  EXPECT_GT(lasted_s, policy.ramp_out_s - 0.005);
  const bool faded = std::any_of(stop, zero, [](const auto& r) {
    return r.state == State::fading || r.state == State::fault;
  });
  if (faded) return;
  const auto held = [](std::int64_t n, const auto& r) {
    return n + (r.defect == Defect::none ? 0 : r.n_elapsed);
  };
  const auto n_held = std::accumulate(stop, zero, std::int64_t{0}, held);
  EXPECT_LT(lasted_s, policy.ramp_out_s + 0.005 + static_cast<double>(n_held) / rate_hz);
}

TEST_P(WallClockEnds, WithARampToNoForce) { ends_with_a_ramp(); }

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
