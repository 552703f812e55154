#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <map>
#include <thread>

#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/lcm_bus.hpp"
#include "plant_sim/run_plant.hpp"
#include "tests/plant_sim/frame.hpp"

// Whole runs of the plant over LCM, against a controller that answers measurement k with k + 1
// units of force on every leg: the force reported as applied tells which command acted.
namespace stillframe {
namespace {

using namespace stillframe_msgs;

constexpr double unit = 1e-6;  // N
constexpr int n_samples = 60;
constexpr std::int64_t instance = 16;  // of the controller

class CountingController {
 public:
  explicit CountingController(std::int64_t run_id)
      : run_id_(run_id), lcm_(open_lcm(lcm_url(""))), thread_([this] { listen(); }) {}
  ~CountingController() { stop(); }

  /// What was applied in measurement k, as a count of commands; once the run has ended.
  const std::map<std::int64_t, double>& applied() {
    stop();
    return applied_;
  }

 private:
  void listen() {
    lcm_->subscribe(channels::measurement, &CountingController::answer, this)->setQueueCapacity(0);
    lcm_->subscribe(channels::run_info, &CountingController::be_ready, this);
    while (!stopped_) handle_one(*lcm_, 20);
  }
  void be_ready(const lcm::ReceiveBuffer*, const std::string&, const run_info_t* info) {
    if (info->run_id != run_id_) return;
    const run_state_t state{.run_id = run_id_,
                            .plant_instance = info->plant_instance,
                            .instance = instance,
                            .sent_ns = monotonic_ns(),
                            .source = "controller",
                            .state = run_state_t::READY,
                            .start_monotonic_ns = 0,
                            .text = ""};
    lcm_->publish(channels::run_state, &state);
  }
  void answer(const lcm::ReceiveBuffer*, const std::string&, const measurement_t* measurement) {
    if (measurement->run_id != run_id_) return;
    applied_[measurement->seq] = measurement->applied_force.back() / unit;
    const double force = unit * static_cast<double>(measurement->seq + 1);
    const command_t command{.run_id = run_id_,
                            .plant_instance = measurement->plant_instance,
                            .instance = instance,
                            .seq = measurement->seq,
                            .time_ns = measurement->time_ns,
                            .sent_ns = monotonic_ns(),
                            .n_legs = measurement->n_legs,
                            .force = std::vector<double>(measurement->applied_force.size(), force),
                            .saturated = 0};
    lcm_->publish(channels::command, &command);
  }
  void stop() {
    stopped_ = true;
    if (thread_.joinable()) thread_.join();
  }

  std::int64_t run_id_;
  std::unique_ptr<lcm::LCM> lcm_;
  std::atomic<bool> stopped_ = false;
  std::map<std::int64_t, double> applied_;
  std::thread thread_;  // last: it uses all of the above
};

/// Commands of an earlier run of the same number, from a controller that has not noticed yet.
void send_stray_commands(std::int64_t run_id, PlantLink& link) {
  const auto lcm = open_lcm(lcm_url(""));
  for (const std::int64_t seq : {5, 30}) {
    const command_t command{.run_id = run_id,
                            .plant_instance = link.info().plant_instance,
                            .instance = 17,
                            .seq = seq,
                            .time_ns = 0,
                            .sent_ns = monotonic_ns(),
                            .n_legs = 6,
                            .force = std::vector<double>(6, 1000 * unit),
                            .saturated = 0};
    lcm->publish(channels::command, &command);
  }
  while (link.n_malformed() < 2 && link.listen(5000)) {
  }
  EXPECT_EQ(link.n_malformed(), 2);
}

/// Runs so many samples and answers what was reported as applied in each, as a count of commands.
std::vector<double> applied_in_run(double delay, const std::string& mode) {
  static std::int64_t run_id = 0;
  Scene scene = test::frame_scene();
  scene.controller->force_limit_n.reset();
  Plant plant(scene, test::table(Eigen::MatrixXd::Zero(6, n_samples)));
  run_info_t info{};
  info.run_id = ++run_id;
  info.plant_instance = 1000 + run_id;
  info.mode = mode;
  info.sample_rate_hz = scene.controller->sample_rate_hz;
  info.delay_samples = delay;
  info.n_samples = n_samples;
  info.n_floor = info.n_legs = 6;
  info.n_frame = 12;
  info.floor_names.resize(6);
  info.leg_names.resize(6);
  info.frame_names.resize(12);
  PlantLink link(lcm_url(""), info);
  CountingController controller(info.run_id);
  if (mode == "wall_clock") send_stray_commands(info.run_id, link);
  EXPECT_EQ(await_controller(link, 60), "");
  const PlantOutcome outcome = mode == "lock_step"
                                   ? run_lock_step(plant, link, {.timeout_s = 60, .progress = {}})
                                   : run_wall_clock(plant, link, {.timeout_s = 60, .progress = {}});
  EXPECT_TRUE(outcome.ended) << outcome.reason;
  std::vector<double> applied;
  for (const auto& [k, count] : controller.applied()) applied.push_back(std::round(count));
  return applied;
}

/// How many commands there are up to the one that acts just before t_k: the newest u[j] with
/// j + delay < k, which is u[ceil(k - delay) - 1].
double due(int k, double delay) { return std::max(0.0, std::ceil(k - delay)); }

class LockStepRun : public testing::TestWithParam<double> {};

TEST_P(LockStepRun, AppliesEveryCommandAfterItsDelay) {
  const std::vector<double> applied = applied_in_run(GetParam(), "lock_step");
  ASSERT_EQ(applied.size(), static_cast<size_t>(n_samples));
  for (int k = 0; k < n_samples; ++k) {
    EXPECT_EQ(applied[static_cast<size_t>(k)], due(k, GetParam())) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(Delays, LockStepRun, testing::Values(0.0, 0.3, 1.0, 1.5, 2.0, 3.75));

class WallClockRun : public testing::TestWithParam<double> {};

TEST_P(WallClockRun, AppliesNoCommandBeforeItsDelay) {
  // How late the threads of a busy machine are is open, but never may a command act early, and some
  // must come in time.
  const std::vector<double> applied = applied_in_run(GetParam(), "wall_clock");
  ASSERT_GT(applied.size(), 1u);
  int in_time = 0;
  for (size_t k = 0; k < applied.size(); ++k) {
    const double expected = due(static_cast<int>(k), GetParam());
    EXPECT_LE(applied[k], expected) << k;
    if (expected > 0 && applied[k] == expected) ++in_time;
  }
  EXPECT_GT(in_time, 0);
}

INSTANTIATE_TEST_SUITE_P(Delays, WallClockRun, testing::Values(1.0, 1.5, 2.0, 3.75));

}  // namespace
}  // namespace stillframe
