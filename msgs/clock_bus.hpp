#pragma once

#include <lcm/lcm-cpp.hpp>

#include "msgs/channels.hpp"
#include "msgs/clock.hpp"
#include "msgs/lcm_bus.hpp"
#include "msgs/peer_clocks.hpp"

namespace stillframe {

/// Publishes the questions of clocks that are due.
inline void ask_clocks(lcm::LCM& lcm, PeerClocks& clocks) {
  while (const auto question = clocks.question(monotonic_ns())) {
    lcm.publish(channels::clock, &*question);
  }
}

/// Takes what came on SF_CLOCK, and answers if it was a question; false if it is no message.
inline bool take_clock(lcm::LCM& lcm, PeerClocks& clocks, const lcm::ReceiveBuffer& buffer) {
  stillframe_msgs::clock_exchange_t message;
  if (!decode(buffer, message)) return false;
  if (const auto answer = clocks.take(message, monotonic_ns())) {
    lcm.publish(channels::clock, &*answer);
  }
  return true;
}

}  // namespace stillframe
