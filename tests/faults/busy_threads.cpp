#include "tests/faults/busy_threads.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>

#include "msgs/clock.hpp"

namespace stillframe::faults {

namespace {

constexpr int n_bursts = 16;  // of a thread, over and over
constexpr double break_s = 0.005;

std::int64_t in_ns(double seconds) { return static_cast<std::int64_t>(seconds * ns_per_s); }

}  // namespace

BusyThreads::BusyThreads(std::optional<int> priority, const std::function<double()>& burst_s) {
  const unsigned n = std::max(1U, std::thread::hardware_concurrency()) + 1;
  for (unsigned i = 0; i < n; ++i) {
    std::vector<double> bursts_s;
    for (int j = 0; j < n_bursts; ++j) bursts_s.push_back(burst_s());
    threads_.emplace_back([this, bursts_s, priority] {
      if (priority) {
        const sched_param parameters{.sched_priority = *priority};
        pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);  // best effort
      }
      run(bursts_s);
    });
  }
}

BusyThreads::~BusyThreads() {
  stop_ = true;
  for (auto& thread : threads_) thread.join();
}

void BusyThreads::run(const std::vector<double>& bursts_s) const {
  for (std::size_t i = 0; !stop_; i = (i + 1) % bursts_s.size()) {
    const std::int64_t end_ns = monotonic_ns() + in_ns(bursts_s[i]);
    while (!stop_ && monotonic_ns() < end_ns) {
    }
    sleep_until(monotonic_ns() + in_ns(break_s));
  }
}

}  // namespace stillframe::faults
