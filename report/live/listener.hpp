#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "report/live/bus_watcher.hpp"

namespace lcm {
class LCM;
}

namespace stillframe::live {

/// Hears a bus from a thread of its own, so that nothing that is done with what was heard can hold
/// the hearing up. It publishes nothing. Set-up.
class Listener {
 public:
  /// Errors: InputError if LCM cannot be opened at the url.
  Listener(const std::string& url, WatchSettings settings);
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  /// A copy of all that has been heard up to now.
  BusWatcher heard() const;

 private:
  class Handler;
  std::unique_ptr<lcm::LCM> lcm_;
  mutable std::mutex mutex_;
  BusWatcher watcher_;
  std::unique_ptr<Handler> handler_;
  std::jthread thread_;
};

}  // namespace stillframe::live
