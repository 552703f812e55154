#include <gtest/gtest.h>

#include <chrono>
#include <lcm/lcm-cpp.hpp>
#include <thread>

#include "controller/lcm_stream.hpp"
#include "msgs/channels.hpp"
#include "msgs/lcm_bus.hpp"
#include "stillframe_msgs/measurement_t.hpp"

namespace stillframe::controller {
namespace {

using namespace std::chrono_literals;

/// Of a plant without channels.
void publish(lcm::LCM& bus, std::int64_t from, std::int64_t to) {
  stillframe_msgs::measurement_t message{};
  message.run_id = 1;
  for (std::int64_t k = from; k < to; ++k) {
    message.seq = k;
    bus.publish(channels::measurement, &message);
    // No faster than a socket's buffer is emptied.
    if (k % 20 == 0) std::this_thread::sleep_for(1ms);
  }
}

// A loop that stands still for longer than its queue is long loses measurements, and says so.
TEST(LcmStreamTest, CountsMeasurementsThatFindNoRoom) {
  stillframe_msgs::run_info_t info{};
  info.run_id = 1;
  const std::string url = lcm_url("");
  LcmStream stream(url, info, 1, {});
  const auto bus = open_lcm(url);
  publish(*bus, 0, 4000);  // fewer than the 4096 that there is room for
  std::this_thread::sleep_for(100ms);
  EXPECT_EQ(stream.n_bad_messages(), 0);
  publish(*bus, 4000, 5000);
  const auto end = std::chrono::steady_clock::now() + 10s;
  while (stream.n_bad_messages() == 0 && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_GT(stream.n_bad_messages(), 0);
  Measurement oldest;
  ASSERT_TRUE(stream.receive(oldest));
  EXPECT_LT(oldest.seq, 4000);  // it is the newest that are let go
}

}  // namespace
}  // namespace stillframe::controller
