#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "stillframe_msgs/controller_status_t.hpp"

namespace stillframe::stalls {

/// When a controller first took a stop that was given at some time, and when it said so.
struct Stop {
  std::int64_t obeyed_ns =
      0;  ///< when the period that took it had its command, CLOCK_MONOTONIC; 0: not yet
  std::int64_t told_ns = 0;  ///< a status that is no more of a loop that holds the frame was sent
};

/// Listens to one bus on a thread of its own.
class Watcher {
 public:
  /// Errors: InputError if LCM cannot be opened.
  explicit Watcher(const std::string& url);
  ~Watcher();
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

  /// The last status of a process.
  std::optional<stillframe_msgs::controller_status_t> status(std::int32_t pid);
  /// Waits for a status of a process that fits; false after limit_s.
  bool wait(std::int32_t pid,
            const std::function<bool(const stillframe_msgs::controller_status_t&)>& fits,
            double limit_s);
  /// From now on looks for a stop that the process obeys.
  void begin_stop(std::int32_t pid);
  /// When the first request to stop since then was sent, 0 if none was heard.
  std::int64_t stop_heard_ns();
  /// Waits until the stop was obeyed and told; what came of it after limit_s.
  Stop stop(double limit_s);

  /// Samples for which two different forces were on the bus before the sample after the next was
  /// measured: two that a plant might act upon.
  std::int64_t n_two_forces();
  std::int64_t n_commands();

 private:
  void on_status(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_records(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_request(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_command(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void on_measurement(const lcm::ReceiveBuffer* buffer, const std::string& channel);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::int32_t, stillframe_msgs::controller_status_t> statuses_;
  std::int32_t pid_ = 0;
  std::int64_t stop_began_ns_ = 0, stop_heard_ns_ = 0;
  Stop stop_;
  std::map<std::int64_t, std::vector<double>> forces_;
  std::int64_t newest_ = -1, n_two_forces_ = 0, n_commands_ = 0;
  std::atomic<bool> end_{false};
  std::unique_ptr<lcm::LCM> lcm_;
  std::thread thread_;
};

}  // namespace stillframe::stalls
