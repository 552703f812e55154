#include "tests/faults/bystander.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>

#include "msgs/clock.hpp"

namespace stillframe::faults {

namespace {

constexpr int priority = 47;  // the loop has 49, its way to the bus 48
constexpr std::int64_t period_ns = 1'000'000, remembered_ns = 3'000'000;

}  // namespace

Bystander::Bystander() {
  for (unsigned cpu = 0; cpu < std::max(1U, std::thread::hardware_concurrency()); ++cpu) {
    threads_.emplace_back([this, cpu] { run(cpu); });
  }
}

Bystander::~Bystander() {
  stop_ = true;
  for (auto& thread : threads_) thread.join();
}

void Bystander::run(unsigned cpu) {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(cpu, &one);
  pthread_setaffinity_np(pthread_self(), sizeof one, &one);  // best effort, as the priority
  const sched_param parameters{.sched_priority = priority};
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  std::int64_t due_ns = monotonic_ns();
  while (!stop_) {
    due_ns += period_ns;
    sleep_until(due_ns);
    const std::int64_t woke_ns = monotonic_ns();
    if (woke_ns - due_ns < remembered_ns) continue;
    const std::lock_guard lock(mutex_);
    late_.push_back({due_ns, woke_ns});
    due_ns = woke_ns;
  }
}

double Bystander::worst_s(std::int64_t begin_ns, std::int64_t end_ns) {
  const std::lock_guard lock(mutex_);
  std::int64_t worst_ns = 0;
  for (const Late& late : late_) {
    if (late.woke_ns < begin_ns || late.due_ns > end_ns) continue;
    worst_ns = std::max(worst_ns, late.woke_ns - late.due_ns);
  }
  return static_cast<double>(worst_ns) / ns_per_s;
}

std::int64_t Bystander::n_later_than(double late_s, std::int64_t begin_ns, std::int64_t end_ns) {
  const std::lock_guard lock(mutex_);
  return std::count_if(late_.begin(), late_.end(), [&](const Late& late) {
    return late.due_ns >= begin_ns && late.woke_ns <= end_ns &&
           static_cast<double>(late.woke_ns - late.due_ns) > late_s * ns_per_s;
  });
}

}  // namespace stillframe::faults
