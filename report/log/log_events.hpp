#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

#include "msgs/message_fit.hpp"

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

}  // namespace stillframe::report
