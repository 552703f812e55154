#include "controller/loop_thread.hpp"

#include <algorithm>

#include "controller/realtime.hpp"
#include "msgs/clock.hpp"

namespace stillframe::controller {

namespace {

constexpr std::int64_t ms = 1'000'000;
// Beyond what ramps take, and what is held; or so many periods, where those are longer.
constexpr double overdue_s = 0.5, overdue_periods = 5, silence_s = 0.1, fewest_periods = 2;

std::int64_t ns(double seconds) { return static_cast<std::int64_t>(seconds * ns_per_s); }

}  // namespace

LoopThread::LoopThread(Loop& loop, const Policy& policy, double sample_rate_hz)
    : loop_(loop),
      most_ns_(ns(policy.ramp_out_s + policy.fade_s +
                  std::max(overdue_s, overdue_periods / sample_rate_hz))),
      silence_ns_(ns(std::max(static_cast<double>(policy.hold_periods) / sample_rate_hz + silence_s,
                              fewest_periods / sample_rate_hz))),
      thread_([this, realtime = policy.realtime, priority = policy.priority, cpu = policy.cpu] {
        if (realtime != Policy::Realtime::off) prepare_thread(priority, cpu);
        run_periodic(loop_, stop_);
      }) {}

LoopThread::~LoopThread() {
  if (!thread_.joinable()) return;
  let_go();
  while (!has_let_go()) sleep_until(monotonic_ns() + ms);
  end();
}

void LoopThread::let_go() noexcept {
  if (until_ns_ != 0) return;
  loop_.request(Request::stop);
  n_answered_ = loop_.counters().n_answered;
  answered_ns_ = monotonic_ns();
  until_ns_ = answered_ns_ + most_ns_;
}

bool LoopThread::has_let_go() noexcept {
  const LoopCounters& counters = loop_.counters();
  const std::int64_t now = monotonic_ns(), n_answered = counters.n_answered;
  if (n_answered != n_answered_) answered_ns_ = now;
  n_answered_ = n_answered;
  return !counters.driving || now > until_ns_ || now - answered_ns_ > silence_ns_;
}

void LoopThread::end() noexcept {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

}  // namespace stillframe::controller
