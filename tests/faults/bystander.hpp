#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace stillframe::faults {

/// A thread that only wants to wake up once a millisecond, with a priority just below that of a
/// controller's threads: what it suffers the machine does to the controller as well.
class Bystander {
 public:
  Bystander();
  ~Bystander();
  Bystander(const Bystander&) = delete;
  Bystander& operator=(const Bystander&) = delete;

  /// How late it woke up at most between two times (CLOCK_MONOTONIC, ns), s. Wake-ups that were
  /// late by less than a few milliseconds are not remembered.
  double worst_s(std::int64_t begin_ns, std::int64_t end_ns);

 private:
  struct Late {
    std::int64_t due_ns, woke_ns;
  };
  void run();

  std::mutex mutex_;
  std::vector<Late> late_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace stillframe::faults
