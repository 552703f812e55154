#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "report/log/file_window.hpp"
#include "report/log/log_events.hpp"

namespace stillframe::report {

/// The events of an LCM log, one after the other, whatever happened to the file. Set-up.
///
/// An event is a mark of four bytes, its number, a time, two lengths, the channel and the payload,
/// and nothing checks any of these. So an event counts only if the file goes on behind it as it
/// should: with the next mark, or, where that mark is damaged, with the next number, or with its
/// end. Where that fails, reading is taken up again at the next mark; a length that was damaged
/// never makes anything be read, or kept in memory, beyond that.
/// Source: LCM's log file format.
class EventFile {
 public:
  /// Errors: InputError if the file is none or cannot be read.
  explicit EventFile(const std::filesystem::path& path) : window_(path) {}

  /// The next event; its views are valid until the next call. False at the end of the file.
  /// Errors: InputError if the disk fails.
  bool next(LogEvent& event);

  const LogDamage& damage() const { return damage_; }
  std::int64_t position() const { return position_; }  ///< bytes read so far
  std::int64_t size() const { return window_.size(); }

 private:
  struct Header {
    bool marked = false;
    std::int64_t number = 0, timestamp_us = 0, channel_length = 0, payload_length = 0;
    std::int64_t end = 0;  ///< of the event; 0 if it cannot be one
  };
  Header header_at(std::int64_t offset);
  bool begins_here(const Header& header) const;
  bool has_successor(const Header& header);
  bool holds_others(const Header& header);
  bool goes_on_behind(const Header& header);
  bool deliver(const Header& header, LogEvent& event);

  FileWindow window_;
  LogDamage damage_;
  std::int64_t position_ = 0;     ///< of what is tried next
  std::int64_t end_of_last_ = 0;  ///< event that was delivered
  std::int64_t last_number_ = -1;
};

}  // namespace stillframe::report
