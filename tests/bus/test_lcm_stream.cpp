#include <gtest/gtest.h>

#include <chrono>
#include <lcm/lcm-cpp.hpp>

#include "controller/lcm_stream.hpp"
#include "msgs/channels.hpp"
#include "msgs/lcm_bus.hpp"
#include "stillframe_msgs/measurement_t.hpp"

namespace stillframe::controller {
namespace {

using namespace std::chrono_literals;

// A loop that stands still for longer than its queue is long loses measurements, and says so.
TEST(LcmStreamTest, CountsMeasurementsThatFindNoRoom) {
  stillframe_msgs::run_info_t info{};
  info.run_id = 1;
  const std::string url = lcm_url("");
  LcmStream stream(url, info, 1, {});
  const auto bus = open_lcm(url);
  stillframe_msgs::measurement_t message{};  // of a plant without channels
  message.run_id = 1;
  // What a full socket drops on the way is not counted: as many as it takes.
  const auto end = std::chrono::steady_clock::now() + 30s;
  for (; stream.state().n_bad == 0 && std::chrono::steady_clock::now() < end; ++message.seq) {
    bus->publish(channels::measurement, &message);
  }
  EXPECT_GT(stream.state().n_bad, 0);
  int n_kept = 0;
  std::int64_t last = -1;
  for (Measurement oldest; stream.receive(oldest); ++n_kept) {
    EXPECT_GT(oldest.seq, last);
    last = oldest.seq;
  }
  EXPECT_GE(n_kept, 4000);  // none was let go of while there was room, for 4096
}

}  // namespace
}  // namespace stillframe::controller
