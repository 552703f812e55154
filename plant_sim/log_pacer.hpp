#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

namespace stillframe {

/// Keeps a lock-step run from outrunning the lcm-logger that records it. lcm-logger drops messages
/// once 30 wait in its queue, which a few milliseconds without a processor are enough for; the
/// pacer compares the bytes that were sent with the size of the log and waits while more than a few
/// samples are missing, as many as a block of the file may hold back. Only time passes: what is
/// sent does not change.
class LogPacer {
 public:
  /// log: the file that lcm-logger writes with --flush-interval=1, which exists. nudge: sends one
  /// small message, on which lcm-logger writes out what it still holds, and answers sent() for it.
  LogPacer(std::filesystem::path log, std::function<void()> nudge);

  /// Waits until the log has caught up with what is on the bus and takes its size as the reference.
  /// Answers false if it has not within 5 s.
  bool begin();
  /// One message of `bytes` on a channel of `channel_length` characters has been sent on the bus.
  void sent(std::size_t bytes, std::size_t channel_length) noexcept;
  /// Waits while the logger may have more messages to take than it has room for: sixteen, or a
  /// block that is not full yet and six, where these are no more than 24. Answers false if it has
  /// not caught up within 5 s.
  bool wait() noexcept;

 private:
  std::int64_t size() const noexcept;

  std::filesystem::path log_;
  std::function<void()> nudge_;
  std::int64_t base_ = 0, sent_ = 0, messages_ = 0;
};

}  // namespace stillframe
