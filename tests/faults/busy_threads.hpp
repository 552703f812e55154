#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <thread>
#include <vector>

namespace stillframe::faults {

/// A busy thread for every processor and one more, until the end of its life.
class BusyThreads {
 public:
  /// priority: of SCHED_FIFO if the system allows it; none: ordinary threads. burst_s gives how
  /// long a thread computes without a break, s; it is called before any thread starts.
  BusyThreads(std::optional<int> priority, const std::function<double()>& burst_s);
  ~BusyThreads();
  BusyThreads(const BusyThreads&) = delete;
  BusyThreads& operator=(const BusyThreads&) = delete;

 private:
  void run(const std::vector<double>& bursts_s) const;

  std::atomic<bool> stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace stillframe::faults
