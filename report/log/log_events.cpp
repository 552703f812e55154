#include "report/log/log_events.hpp"

#include "report/log/event_file.hpp"

namespace stillframe::report {

LogDamage for_each_event(const std::filesystem::path& path,
                         const std::function<void(const LogEvent&)>& receive) {
  EventFile file(path);
  LogEvent event;
  while (file.next(event)) receive(event);
  return file.damage();
}

}  // namespace stillframe::report
