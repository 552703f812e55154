#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace stillframe::faults {

/// Threads that only want to wake up once a millisecond, one on each processor, with a priority
/// just below that of a controller's: what they suffer the machine does to the controller as well.
class Bystander {
 public:
  Bystander();
  ~Bystander();
  Bystander(const Bystander&) = delete;
  Bystander& operator=(const Bystander&) = delete;

  /// How late any woke up at most between two times (CLOCK_MONOTONIC, ns), s. Wake-ups that were
  /// late by less than a few milliseconds are not remembered.
  double worst_s(std::int64_t begin_ns, std::int64_t end_ns);
  /// How often one woke up later than that (from a few milliseconds on) between two times.
  std::int64_t n_later_than(double late_s, std::int64_t begin_ns, std::int64_t end_ns);

 private:
  struct Late {
    std::int64_t due_ns, woke_ns;
  };
  void run(unsigned cpu);

  std::mutex mutex_;
  std::vector<Late> late_;
  std::atomic<bool> stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace stillframe::faults
