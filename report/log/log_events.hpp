#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

#include "report/log/message_fit.hpp"

namespace stillframe::report {

/// One event of an LCM log; the views are valid only inside the call that receives it.
struct LogEvent {
  std::int64_t timestamp_us = 0;  ///< since the UNIX epoch, by the logger's clock
  std::string_view channel;
  std::string_view payload;  ///< empty if it was larger than largest_payload

  static constexpr std::int64_t largest_payload = std::int64_t{64} << 20;
};

/// What could not be read of a log.
struct LogDamage {
  std::int64_t n_damaged = 0;  ///< places where reading failed and was taken up again further on
  std::int64_t skipped_bytes = 0;  ///< at these places
  std::int64_t unread_bytes = 0;   ///< after the last whole event
};

/// Calls `receive` for every readable event of an LCM log, in the order of the file.
/// Errors: InputError if the file cannot be opened, is not a file, or the disk fails.
LogDamage for_each_event(const std::filesystem::path& path,
                         const std::function<void(const LogEvent&)>& receive);

/// The message of type Message in a payload. Returns false if the bytes are not one whole message.
template <typename Message>
bool decode(std::string_view payload, Message& message) {
  if (fit<Message>(payload) != Fit::whole) return false;
  // lcm-gen's decoders leave a list of no entries as it was.
  message = Message();
  const auto size = static_cast<int>(payload.size());
  return message.decode(payload.data(), 0, size) == size;
}

}  // namespace stillframe::report
