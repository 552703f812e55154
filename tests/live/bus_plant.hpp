#pragma once

#include <atomic>
#include <memory>
#include <stop_token>
#include <thread>

#include "msgs/clock.hpp"
#include "msgs/lcm_bus.hpp"
#include "tests/live/sample_messages.hpp"

namespace stillframe::live::sample {

/// A run on the bus from a number on, as long as the object lives; it describes itself if it is
/// told to. Its time goes half as fast as that of the world and only every tenth measurement is
/// answered, so that the socket of a listener on a busy machine does not overflow so soon.
class BusPlant {
 public:
  BusPlant(std::int64_t run_id, std::int64_t first, bool describes) : lcm_(open_lcm(lcm_url(""))) {
    thread_ = std::jthread([this, run_id, first, describes](const std::stop_token& stop) {
      std::int64_t next = monotonic_ns();
      for (std::int64_t k = first; !stop.stop_requested(); ++k, next += 2 * ms) {
        if ((k - first) % 500 == 0) {
          if (describes) publish(channels::run_info, info(run_id));
          publish(channels::run_state,
                  state(run_id, "plant", stillframe_msgs::run_state_t::RUNNING));
        }
        if ((k - first) % 100 == 0) publish(channels::status, status(run_id));
        if ((k - first) % 10 == 0) {
          publish(channels::loop, records(run_id, {record(next, 90'000, 7000)}));
        }
        publish(channels::measurement, measurement(run_id, k));
        if (k % 10 == 0) publish(channels::command, command(run_id, k));
        sleep_until(next + 2 * ms);
      }
    });
  }

 private:
  template <class Message>
  void publish(const char* channel, const Message& message) {
    lcm_->publish(channel, &message);
  }

  std::unique_ptr<lcm::LCM> lcm_;
  std::jthread thread_;
};

}  // namespace stillframe::live::sample
