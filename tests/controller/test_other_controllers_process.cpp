#include "controller/supervisor.hpp"
#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/peer_clocks.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "tests/controller/controller_process.hpp"

// What a controller that goes by the clock makes of signs of another one.
namespace stillframe::controller {
namespace {

using stillframe_msgs::controller_status_t;

class OtherControllers : public ControllerProcess {
 protected:
  /// A run of n samples, each with what `beside` does beside it. Paced by the clock because that is
  /// the mode; how well it is kept is not judged here.
  template <class Beside>
  void run(toy::FakePlant& plant, std::int64_t n, Beside beside) {
    ASSERT_EQ(plant.announce(), run_state_t::READY);
    const std::int64_t start = monotonic_ns() + 20'000'000;
    plant.publish_state(run_state_t::RUNNING, start);
    for (std::int64_t k = 0; k < n; ++k) {
      sleep_until(start + k * 1'000'000);
      measurement_t measurement = plant.measure(k);
      beside(measurement);
      plant.publish(measurement);
      while (plant.take(0)) {
      }
    }
    plant.publish_state(run_state_t::ENDED);
  }

  /// Nothing here is about what the loop does, and a frame that stands still would be a fault.
  stillframe_msgs::run_info_t passive(std::int64_t n) const {
    auto info = toy::run_info(gains, 9, "wall_clock", n);
    info.loop = "passive";
    return info;
  }

  const Gains gains = toy::gains(5, 1000, 1);
};

TEST_F(OtherControllers, OneThatThePlantDoesNotObeyGoes) {
  toy::FakePlant plant(passive(100'000));
  ChildProcess controller(command_line(gains));
  run(plant, 2000, [](measurement_t& measurement) { measurement.controller_instance = 99; });
  EXPECT_EQ(controller.wait(), 3);
  EXPECT_TRUE(contains(controller.err(), "the plant obeys another controller")) << controller.err();
}

// Of a recording: of this run and plant, but said long ago; and said now, but for another plant.
TEST_F(OtherControllers, OneThatIsRecordedIsNone) {
  toy::FakePlant plant(passive(1000));
  ChildProcess controller(command_line(gains));
  controller_status_t status{};
  status.run_id = 9;
  status.instance = 99;
  status.started_ns = 1;
  status.pid = 29195;
  status.state = controller_status_t::ACTIVE;
  run(plant, 1000, [&](measurement_t& measurement) {
    if (measurement.seq % 20 != 0) return;
    status.plant_instance = plant.info().plant_instance;
    status.sent_ns = monotonic_ns() - fresh_ns;
    plant.lcm().publish(channels::status, &status);
    ++status.plant_instance;
    status.sent_ns = monotonic_ns();
    plant.lcm().publish(channels::status, &status);
  });
  EXPECT_EQ(controller.wait(), 0) << controller.err();
}

TEST_F(OtherControllers, OneThatLivesIsGivenWayTo) {
  toy::FakePlant plant(passive(1000));
  ChildProcess controller(command_line(gains));
  controller_status_t status{};
  status.run_id = 9;
  status.plant_instance = plant.info().plant_instance;
  status.instance = 99;
  status.started_ns = 1;
  status.pid = 29195;
  status.state = controller_status_t::ACTIVE;
  run(plant, 1000, [&](measurement_t& measurement) {
    if (measurement.seq % 20 != 0) return;
    status.sent_ns = monotonic_ns();
    plant.lcm().publish(channels::status, &status);
  });
  EXPECT_EQ(controller.wait(), 3);
  EXPECT_TRUE(contains(controller.err(), "another controller (process 29195")) << controller.err();
}

}  // namespace
}  // namespace stillframe::controller
