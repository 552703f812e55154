#include <csignal>

#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "tests/controller/controller_process.hpp"

namespace stillframe::controller {
namespace {

using stillframe_msgs::controller_status_t;

/// A plant by the clock whose sensors can stand still, which is a fault that only a person ends.
class LatchProcess : public ControllerProcess {
 protected:
  LatchProcess() {
    plant.lcm().subscribe(channels::status, &LatchProcess::on_status, this)->setQueueCapacity(0);
  }

  void begin() {
    while (plant.take(100)) {  // what the controller before had to say
    }
    plant.states.clear();
    EXPECT_EQ(plant.announce(), run_state_t::READY);
    anew();
  }
  /// The plant is started again, as the same run.
  void anew() {
    start = monotonic_ns() + 20'000'000;
    k = 0;
    for (int i = 0; i < 2; ++i) plant.publish_state(run_state_t::RUNNING, start);
  }
  /// Goes on until the controller says what is waited for, or for half a minute.
  template <class Condition>
  bool goes_on_until(Condition condition, bool moving) {
    status = {};
    const auto still = plant.measure(0);
    for (const std::int64_t last = k + 30'000; k < last; ++k) {
      sleep_until(start + k * 1'000'000);
      auto measurement = plant.measure(k);
      if (!moving) measurement.sigma = still.sigma;
      plant.publish(measurement);
      while (plant.take(0)) {
      }
      plant.move(std::vector<double>(4, 0.0));
      // What is said of the run that was before does not count.
      if (status.n_periods > 0 && k > 200 && condition(status)) return true;
    }
    return false;
  }
  static bool is_latched(const controller_status_t& status) {
    return status.latched != 0 && status.state == controller_status_t::FAULT;
  }
  static bool is_arming(const controller_status_t& status) {
    return status.latched == 0 && status.state != controller_status_t::FAULT &&
           status.state != controller_status_t::IDLE;
  }

  Gains gains = toy::gains(5, 1000, 1);
  toy::FakePlant plant{toy::run_info(gains, 9, "wall_clock", 1'000'000)};
  controller_status_t status{};
  std::int64_t start = 0, k = 0;

 private:
  void on_status(const lcm::ReceiveBuffer*, const std::string&,
                 const controller_status_t* message) {
    status = *message;
  }
};

TEST_F(LatchProcess, ALatchedFaultOutlivesPlantAndControllerUntilAPersonClearsIt) {
  {
    ChildProcess controller(command_line(gains));
    begin();
    ASSERT_TRUE(goes_on_until(is_latched, false));
    anew();
    // For longer than it would take to arm again, by the plant's own samples.
    const auto still = [&](const controller_status_t& s) { return k > 1500 && is_latched(s); };
    ASSERT_TRUE(goes_on_until(still, true)) << "a plant that begins anew clears nothing";
    controller.signal(SIGTERM);
    EXPECT_EQ(controller.wait(), 4);
    EXPECT_TRUE(contains(controller.err(), "not_alive")) << controller.err();
  }
  {
    ChildProcess controller(command_line(gains));
    begin();
    ASSERT_TRUE(goes_on_until(is_latched, true)) << "another controller knows of it";
    controller.signal(SIGKILL);
    controller.wait();
  }
  {
    ChildProcess controller(command_line(gains, {"--reset"}));
    begin();
    ASSERT_TRUE(goes_on_until(is_arming, true));
    controller.signal(SIGTERM);
    controller.wait();
    EXPECT_FALSE(contains(controller.err(), "latched")) << controller.err();
  }
  {
    ChildProcess controller(command_line(gains));
    begin();
    ASSERT_TRUE(goes_on_until(is_arming, true)) << "what was cleared stays so";
    controller.signal(SIGTERM);
    controller.wait();
  }
}

TEST_F(LatchProcess, ALatchThatCannotBeReadExits2AndThePlantIsTold) {
  const auto expect_exit_2 = [&](const char* reason) {
    plant.states.clear();
    ChildProcess controller(command_line(gains));
    EXPECT_EQ(plant.announce(), run_state_t::READY);
    plant.publish_state(run_state_t::RUNNING, monotonic_ns());
    EXPECT_EQ(controller.wait(), 2);
    EXPECT_TRUE(contains(controller.err(), reason)) << controller.err();
    while (plant.states.back().state != run_state_t::FAILED && plant.take(1000)) {
    }
    EXPECT_EQ(plant.states.back().state, run_state_t::FAILED);
  };
  const auto latch = folder / "latch.yaml";
  std::ofstream(latch) << "fault: something\n";
  expect_exit_2("latch.yaml:1:");
  // A link to itself, because a folder that may not be read is read by root.
  std::filesystem::remove(latch);
  std::filesystem::create_symlink(latch, latch);
  expect_exit_2("not known whether a fault is latched");
}

// Whoever writes a comment into the scene has mended nothing.
TEST_F(LatchProcess, ASceneThatWasEditedKeepsItsLatch) {
  std::filesystem::create_directory(folder / "stillframe");
  std::ofstream(folder / "stillframe/latch-toy.yaml") << "fault: restless\nleg: leg_3\n";
  command_line(gains);
  ChildProcess controller({"env", "XDG_STATE_HOME=" + folder.string(), program, "--gains",
                           gains_file, "--flight-folder", folder});
  begin();
  EXPECT_TRUE(goes_on_until(is_latched, true)) << plant.info().scene_hash;
  EXPECT_TRUE(contains(status.text, "restless, leg_3 first")) << status.text;
  controller.signal(SIGTERM);
  EXPECT_EQ(controller.wait(), 4);
  EXPECT_TRUE(contains(controller.err(), "latched fault: restless, leg_3 first"))
      << controller.err();
}

}  // namespace
}  // namespace stillframe::controller
