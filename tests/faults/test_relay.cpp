#include <gtest/gtest.h>

#include <algorithm>
#include <lcm/lcm-cpp.hpp>
#include <string>
#include <vector>

#include "msgs/channels.hpp"
#include "msgs/lcm_bus.hpp"
#include "stillframe_msgs/command_t.hpp"
#include "stillframe_msgs/run_state_t.hpp"
#include "tests/faults/relay.hpp"

namespace stillframe::faults {
namespace {

using namespace stillframe_msgs;

constexpr int soon_ms = 20, limit_ms = 10'000;

/// One side of the relay, with all channels that were heard there.
class Side {
 public:
  explicit Side(const std::string& url) : lcm_(url) { lcm_.subscribe(".*", &Side::on_any, this); }

  template <class Message>
  void publish(const char* channel, const Message& message) {
    lcm_.publish(channel, &message);
  }
  /// Takes messages until one is on the channel, as long as they come.
  bool hears(const std::string& channel, int wait_ms) {
    const auto n = count(channel);
    while (count(channel) == n) {
      if (lcm_.handleTimeout(wait_ms) <= 0) return false;
    }
    return true;
  }
  std::ptrdiff_t count(const std::string& channel) const {
    return std::count(heard_.begin(), heard_.end(), channel);
  }

 private:
  // Of the channel that has both directions, with the source.
  void on_any(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
    run_state_t state;
    const bool both = channel == channels::run_state && decode(*buffer, state);
    heard_.push_back(both ? channel + " " + state.source : channel);
  }

  lcm::LCM lcm_;
  std::vector<std::string> heard_;
};

class RelayTest : public testing::Test {
 protected:
  static constexpr const char* plant_url = "udpm://239.255.76.67:7790?ttl=0";
  static constexpr const char* controller_url = "udpm://239.255.76.67:7791?ttl=0";

  RelayTest()
      : plant(plant_url), controller(controller_url), relay(plant_url, controller_url, 1000) {
    // Until the relay's thread has subscribed.
    for (int i = 0; i < limit_ms / soon_ms; ++i) {
      plant.publish(channels::run_state, state("plant"));
      if (controller.hears("SF_RUN_STATE plant", soon_ms)) break;
    }
  }

  static run_state_t state(const char* source) {
    return {.run_id = 1, .source = source, .state = 0, .start_monotonic_ns = 0, .text = ""};
  }
  static command_t command() {
    command_t message{};
    message.n_legs = 6;
    message.force.assign(6, 1.0);
    return message;
  }
  static measurement_t measurement(std::int64_t seq) {
    measurement_t message{};
    message.seq = seq;
    message.n_legs = message.n_frame = 6;
    message.sigma = message.applied_force = message.frame_acceleration = {1, 2, 3, 4, 5, 6};
    return message;
  }

  Side plant, controller;
  Relay relay;
};

TEST_F(RelayTest, PassesEachChannelInItsDirectionAndEchoesNothing) {
  plant.publish(channels::measurement, measurement(0));
  EXPECT_TRUE(controller.hears(channels::measurement, limit_ms));
  controller.publish(channels::command, command());
  EXPECT_TRUE(plant.hears(channels::command, limit_ms));
  controller.publish(channels::run_state, state("controller"));
  EXPECT_TRUE(plant.hears("SF_RUN_STATE controller", limit_ms));
  // What comes behind a marker on each side would have been an echo before it.
  plant.publish(channels::measurement, measurement(1));
  ASSERT_TRUE(controller.hears(channels::measurement, limit_ms));
  EXPECT_EQ(controller.count(channels::measurement), 2);
  EXPECT_EQ(controller.count(channels::command), 1);
  EXPECT_EQ(plant.count(channels::command), 1);
  EXPECT_EQ(plant.count("SF_RUN_STATE controller"), 1);
}

TEST_F(RelayTest, InflictsAFaultOnSoManySamples) {
  relay.inflict({.measurements = {.loss = 1}, .commands = {}}, 1, 5);
  for (std::int64_t seq = 0; seq < 8; ++seq) plant.publish(channels::measurement, measurement(seq));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(controller.hears(channels::measurement, limit_ms));
  EXPECT_FALSE(controller.hears(channels::measurement, soon_ms));
  EXPECT_EQ(relay.counts().measurements.n_lost, 5);
  // The trace is from before the fault.
  EXPECT_EQ(relay.look([](const Trace& trace) { return trace.sample(); }), 7);
  EXPECT_EQ(relay.look([](const Trace& trace) { return trace.runs.back().frame[3][5]; }), 6);
}

TEST_F(RelayTest, ASampleZeroBeginsAnotherRun) {
  for (const std::int64_t seq : {0, 1, 2, 0, 1}) {
    plant.publish(channels::measurement, measurement(seq));
    ASSERT_TRUE(controller.hears(channels::measurement, limit_ms));
  }
  EXPECT_EQ(relay.look([](const Trace& trace) { return trace.runs.size(); }), 2u);
  EXPECT_EQ(relay.look([](const Trace& trace) { return trace.sample(); }), 1);
}

}  // namespace
}  // namespace stillframe::faults
