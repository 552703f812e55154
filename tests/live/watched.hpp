#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "report/live/live_view.hpp"
#include "tests/live/sample_messages.hpp"

namespace stillframe::live {

/// A bus that is watched, with a clock that the test sets.
class Watched : public testing::Test {
 protected:
  template <class Message>
  void hear(const char* channel, const Message& message) {
    watcher.take(channel, sample::encoded(message), now);
  }
  void hear_info(std::int64_t run_id) { hear(channels::run_info, sample::info(run_id)); }

  /// Measurements and commands first to last, at their rate.
  void hear_samples(std::int64_t run_id, std::int64_t first, std::int64_t last) {
    for (std::int64_t seq = first; seq <= last; ++seq) {
      now += sample::ms;
      hear(channels::measurement, sample::measurement(run_id, seq));
      hear(channels::command, sample::command(run_id, seq));
    }
  }

  LiveView view() const { return look(watcher, "udpm://a.bus", now); }
  std::int64_t run_id() const { return watcher.run() ? watcher.run()->run_id : 0; }
  const ChannelTraffic& traffic(const char* channel) const {
    return watcher.channels().find(channel)->second;
  }
  static bool says(const LiveView& view, const std::string& part) {
    return std::any_of(view.notes.begin(), view.notes.end(), [&](const std::string& note) {
      return note.find(part) != std::string::npos;
    });
  }

  std::int64_t now = 1000 * sample::second;
  BusWatcher watcher{WatchSettings{}, now};
};

}  // namespace stillframe::live
