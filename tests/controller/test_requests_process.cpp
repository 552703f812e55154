#include <algorithm>
#include <cmath>
#include <fstream>

#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/peer_clocks.hpp"
#include "stillframe_msgs/control_request_t.hpp"
#include "stillframe_msgs/controller_status_t.hpp"
#include "tests/controller/controller_process.hpp"

// Which requests a controller obeys that holds the frame.
namespace stillframe::controller {
namespace {

using stillframe_msgs::control_request_t;
using stillframe_msgs::controller_status_t;

class RequestsProcess : public ControllerProcess {
 protected:
  RequestsProcess() {
    plant.lcm().subscribe(channels::status, &RequestsProcess::on_status, this)->setQueueCapacity(0);
  }

  void begin() {
    ASSERT_EQ(plant.announce(), run_state_t::READY);
    start = monotonic_ns() + 20'000'000;
    plant.publish_state(run_state_t::RUNNING, start);
  }
  /// Until the controller says what is waited for, or for half a minute.
  template <class Condition>
  bool goes_on_until(Condition condition) {
    for (const std::int64_t last = k + 30'000; k < last;) {
      sleep_until(start + k * 1'000'000);
      plant.publish(plant.measure(k));
      while (plant.take(0)) {
      }
      // A floor that keeps the frame moving, 10 mm/s^2 at 2 Hz: what stands still is not armed.
      const double floor = 0.01 * std::sin(two_pi * 0.002 * static_cast<double>(k));
      plant.move(plant.commands.empty() ? std::vector<double>(4, 0.0) : plant.commands.back().force,
                 floor);
      ++k;
      if (!statuses.empty() && condition(statuses.back())) return true;
    }
    return false;
  }
  static auto is(std::int32_t state) {
    return [state](const controller_status_t& status) { return status.state == state; };
  }

  void publish(control_request_t request) { plant.lcm().publish(channels::request, &request); }
  static control_request_t request(std::int32_t what, std::int64_t nonce, std::int64_t asked_ns) {
    return {
        .run_id = 9, .nonce = nonce, .asked_ns = asked_ns, .sent_ns = asked_ns, .request = what};
  }
  /// As `stillframe ctl` asks, every 0.1 s until the status names it. Answers what it asked.
  control_request_t ask(std::int32_t what, std::int64_t nonce) {
    control_request_t asked = request(what, nonce, monotonic_ns());
    EXPECT_TRUE(goes_on_until([&](const controller_status_t& status) {
      asked.sent_ns = monotonic_ns();
      if (k % 100 == 0) publish(asked);
      return status.nonce == nonce && status.answer.empty();
    }));
    return asked;
  }
  /// What is said for a third of a second, each time as `repeated` says, does not stop the loop. A
  /// request that comes behind and is answered shows that it was heard.
  template <class Repeated>
  void expect_ignored(Repeated repeated, std::int64_t nonce_behind) {
    statuses.clear();
    const std::int64_t until = k + 333;
    EXPECT_TRUE(goes_on_until([&](const controller_status_t&) {
      if (k % 20 == 0) publish(repeated());
      return k >= until;
    }));
    ask(control_request_t::RESET, nonce_behind);
    // Whatever the machine does to the loop meanwhile leads to neither state by itself.
    const auto obeys = [nonce = repeated().nonce](const controller_status_t& status) {
      return status.state == controller_status_t::RAMP_OUT ||
             status.state == controller_status_t::IDLE || status.nonce == nonce;
    };
    EXPECT_TRUE(std::none_of(statuses.begin(), statuses.end(), obeys));
  }

  Gains gains = toy::gains(5, 1000, 1);
  toy::FakePlant plant{toy::run_info(gains, 9, "wall_clock", 1'000'000)};
  std::vector<controller_status_t> statuses;
  std::int64_t start = 0, k = 0;

 private:
  void on_status(const lcm::ReceiveBuffer*, const std::string&,
                 const controller_status_t* message) {
    statuses.push_back(*message);
  }
};

TEST_F(RequestsProcess, AStopThatIsOldOrWasObeyedBeforeStopsNothing) {
  // Nobody measures what moves this frame.
  const auto policy = folder / "policy.yaml";
  std::ofstream(policy) << "limits: {free_rate_n_per_s: 1.0e+6}\n";
  ChildProcess controller(command_line(gains, {"--policy", policy}));
  begin();
  ASSERT_TRUE(goes_on_until(is(controller_status_t::ACTIVE)));
  // A recording of somebody else's, sound but for its age.
  const auto old = request(control_request_t::STOP, 1, monotonic_ns() - fresh_ns);
  expect_ignored([&] { return old; }, 2);

  control_request_t stop = ask(control_request_t::STOP, 3);
  ASSERT_TRUE(goes_on_until(is(controller_status_t::IDLE))) << "one that is fresh";
  ask(control_request_t::START, 4);
  ASSERT_TRUE(goes_on_until(is(controller_status_t::ACTIVE)));
  // Its asker has not heard that it was obeyed, and goes on asking.
  expect_ignored(
      [&] {
        stop.sent_ns = monotonic_ns();
        return stop;
      },
      5);
  plant.publish_state(run_state_t::ENDED);
  EXPECT_EQ(controller.wait(), 0) << controller.err();
}

}  // namespace
}  // namespace stillframe::controller
