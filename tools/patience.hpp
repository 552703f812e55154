#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace stillframe::tools {

/// Says on a terminal's standard error, from the third second on, what the program is at and for
/// how long; the line is taken away in the end. Silent where standard error is no terminal.
class Patience {
 public:
  explicit Patience(std::string what);
  ~Patience();
  Patience(const Patience&) = delete;
  Patience& operator=(const Patience&) = delete;

  /// The next thing that takes its time, and how much of it is done, in percent; below 0 if that is
  /// not known.
  void now(std::string what, double percent = -1);

 private:
  void watch(const std::stop_token& stop);
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::string what_;
  double percent_ = -1;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::jthread watcher_;
};

}  // namespace stillframe::tools
