#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace stillframe::report {

/// One event of a log as LCM's own reader finds it.
struct LoggedEvent {
  std::int64_t number = 0, timestamp_us = 0;
  std::string channel, payload;
  std::size_t begin = 0, end = 0;  ///< in the file

  bool operator==(const LoggedEvent&) const = default;
};

/// All events of a sound log, by LCM's own reader.
std::vector<LoggedEvent> events_by_lcm(const std::filesystem::path& log);

std::string bytes_of(const std::filesystem::path& file);
void write_bytes_to(const std::filesystem::path& file, const std::string& bytes);

}  // namespace stillframe::report
