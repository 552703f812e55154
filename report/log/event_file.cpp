#include "report/log/event_file.hpp"

#include <algorithm>

#include "msgs/big_endian.hpp"

namespace stillframe::report {

namespace {

constexpr std::string_view mark("\xED\xA1\xDA\x01", 4);
constexpr std::int64_t mark_size = 4, number_end = 12, header_size = 28;

/// LCM's own reader takes no longer names.
constexpr std::int64_t longest_channel = 999;

std::int64_t number_behind(std::int64_t number) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(number) + 1);
}

}  // namespace

EventFile::Header EventFile::header_at(std::int64_t offset) {
  const std::string_view bytes = window_.at(offset, header_size);
  if (static_cast<std::int64_t>(bytes.size()) < header_size) return {};
  Header header{.marked = bytes.starts_with(mark),
                .number = read_int64(bytes.data() + mark_size),
                .timestamp_us = read_int64(bytes.data() + number_end),
                .channel_length = read_int32(bytes.data() + 20),
                .payload_length = read_int32(bytes.data() + 24)};
  const std::int64_t end = offset + header_size + header.channel_length + header.payload_length;
  const bool possible = header.channel_length >= 1 && header.channel_length <= longest_channel &&
                        header.payload_length >= 0 && end <= window_.size();
  if (possible) header.end = end;
  return header;
}

bool EventFile::begins_here(const Header& header) const {
  if (header.end == 0) return false;
  return header.marked ||
         (position_ == end_of_last_ && header.number == number_behind(last_number_));
}

bool EventFile::has_successor(const Header& header) {
  if (header.end == 0) return false;
  const std::string_view next = window_.at(header.end, number_end);
  return static_cast<std::int64_t>(next.size()) == number_end &&
         read_int64(next.data() + mark_size) == number_behind(header.number);
}

bool EventFile::holds_others(const Header& header) {
  std::int64_t inside = position_ + mark_size;
  const std::int64_t end = std::min(header.end, inside + LogEvent::largest_payload);
  while ((inside = window_.find(mark, inside, end)) >= 0) {
    if (has_successor(header_at(inside))) return true;
    inside += mark_size;
  }
  return false;
}

bool EventFile::goes_on_behind(const Header& header) {
  // Asked for together with the event, so that the window need not go back for it.
  const std::int64_t ahead = std::min(header.end - position_, LogEvent::largest_payload);
  window_.at(position_, ahead + number_end);
  if (has_successor(header)) return true;
  const std::string_view next = window_.at(header.end, number_end);
  if (static_cast<std::int64_t>(next.size()) < number_end) {
    return mark.starts_with(next.substr(0, mark_size));
  }
  // Another number behind a mark is the seam of two logs, or the end of a damaged length that leads
  // to some event further on: then those between are inside.
  return next.starts_with(mark) && !holds_others(header);
}

bool EventFile::deliver(const Header& header, LogEvent& event) {
  const bool fits = header.payload_length <= LogEvent::largest_payload;
  const std::int64_t wanted =
      header_size + header.channel_length + (fits ? header.payload_length : 0);
  const std::string_view bytes = window_.at(position_, wanted);
  if (static_cast<std::int64_t>(bytes.size()) < wanted) return false;
  const auto name = static_cast<std::size_t>(header.channel_length);
  event = {header.timestamp_us, bytes.substr(header_size, name), bytes.substr(header_size + name)};
  if (position_ > end_of_last_) {
    ++damage_.n_damaged;
    damage_.skipped_bytes += position_ - end_of_last_;
  }
  position_ = end_of_last_ = header.end;
  last_number_ = header.number;
  return true;
}

bool EventFile::next(LogEvent& event) {
  while (position_ >= 0 && position_ < window_.size()) {
    const Header header = header_at(position_);
    if (begins_here(header) && goes_on_behind(header) && deliver(header, event)) return true;
    position_ = window_.find(mark, position_ + 1, window_.size());
  }
  position_ = window_.size();
  damage_.unread_bytes = window_.size() - end_of_last_;
  return false;
}

}  // namespace stillframe::report
