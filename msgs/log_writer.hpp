#pragma once

#include <cstdint>
#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <vector>

namespace stillframe {

/// An LCM log that is written without a bus, event by event as lcm-logger does it. Set-up:
/// construction; write() allocates only until its buffer has grown.
class LogWriter {
 public:
  /// Errors: InputError if the file cannot be made.
  explicit LogWriter(const std::filesystem::path& file);

  /// Writes a message on a channel, with the time of now or another (us). False if the file takes
  /// no more.
  template <class Message>
  bool write(const char* channel, const Message& message, std::int64_t time_us = now_us()) {
    bytes_.resize(static_cast<size_t>(message.getEncodedSize()));
    message.encode(bytes_.data(), 0, static_cast<int>(bytes_.size()));
    return write_bytes(channel, time_us);
  }
  /// Hands all to the system; false if it takes no more.
  bool finish();

 private:
  static std::int64_t now_us();
  bool write_bytes(const char* channel, std::int64_t time_us);

  lcm::LogFile file_;
  lcm::LogEvent event_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace stillframe
