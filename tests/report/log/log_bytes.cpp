#include "tests/report/log/log_bytes.hpp"

#include <lcm/eventlog.h>

#include <fstream>
#include <iterator>

namespace stillframe::report {

std::vector<LoggedEvent> events_by_lcm(const std::filesystem::path& path) {
  std::vector<LoggedEvent> events;
  lcm_eventlog_t* log = lcm_eventlog_create(path.c_str(), "r");
  if (log == nullptr) return events;
  std::size_t begin = 0;
  while (lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log)) {
    const auto end = static_cast<std::size_t>(ftello(log->f));
    events.push_back({event->eventnum, event->timestamp,
                      std::string(event->channel, static_cast<std::size_t>(event->channellen)),
                      std::string(static_cast<const char*>(event->data),
                                  static_cast<std::size_t>(event->datalen)),
                      begin, end});
    begin = end;
    lcm_eventlog_free_event(event);
  }
  lcm_eventlog_destroy(log);
  return events;
}

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_bytes_to(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace stillframe::report
