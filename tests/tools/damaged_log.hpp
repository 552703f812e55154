#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <vector>

#include "msgs/channels.hpp"
#include "stillframe_msgs/measurement_t.hpp"

namespace stillframe::test {

/// A log with measurements changed and other messages left out.
template <class Change, class LeaveOut>
void damage_log(const std::filesystem::path& log, const std::filesystem::path& damaged,
                const Change& change, const LeaveOut& leave_out) {
  using stillframe_msgs::measurement_t;
  lcm::LogFile from(log.string(), "r"), to(damaged.string(), "w");
  int n = 0;
  while (const lcm::LogEvent* event = from.readNextEvent()) {
    if (leave_out(event->channel, n++)) continue;
    lcm::LogEvent copy = *event;
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(event->datalen));
    if (measurement_t m; event->channel == channels::measurement) {
      EXPECT_GE(m.decode(event->data, 0, event->datalen), 0);
      change(m);
      m.encode(bytes.data(), 0, event->datalen);
      copy.data = bytes.data();
    }
    to.writeEvent(&copy);
  }
}

}  // namespace stillframe::test
