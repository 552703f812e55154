#include "report/log/log_events.hpp"

#include <lcm/eventlog.h>

#include <memory>

#include "core/yaml/input_error.hpp"

namespace stillframe::report {

namespace {

struct CloseLog {
  void operator()(lcm_eventlog_t* log) const { lcm_eventlog_destroy(log); }
};
struct FreeEvent {
  void operator()(lcm_eventlog_event_t* event) const { lcm_eventlog_free_event(event); }
};
using Event = std::unique_ptr<lcm_eventlog_event_t, FreeEvent>;

std::string_view channel_of(const lcm_eventlog_event_t& event) {
  return {event.channel, static_cast<std::size_t>(event.channellen)};
}

std::string_view payload_of(const lcm_eventlog_event_t& event) {
  return {static_cast<const char*>(event.data), static_cast<std::size_t>(event.datalen)};
}

}  // namespace

LogDamage for_each_event(const std::filesystem::path& path,
                         const std::function<void(const LogEvent&)>& receive) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    throw InputError(path.string() + ": there is no such LCM log");
  }
  std::unique_ptr<lcm_eventlog_t, CloseLog> log(lcm_eventlog_create(path.c_str(), "r"));
  if (!log) throw InputError(path.string() + ": the LCM log cannot be opened for reading");

  const auto file_size = static_cast<std::int64_t>(std::filesystem::file_size(path));
  LogDamage damage;
  std::int64_t end_of_last = 0;
  while (true) {
    const Event event(lcm_eventlog_read_next_event(log.get()));
    const std::int64_t position = ftello(log->f);
    if (event) {
      receive({event->timestamp, channel_of(*event), payload_of(*event)});
      end_of_last = position;
    } else if (std::feof(log->f) || position >= file_size) {
      break;
    } else {
      // The reader has stopped inside a damaged event; its next call looks for the next event's
      // mark.
      ++damage.n_damaged;
    }
  }
  damage.unread_bytes = file_size - end_of_last;
  return damage;
}

}  // namespace stillframe::report
