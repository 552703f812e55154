#include "controller/lock_step.hpp"

#include <algorithm>
#include <optional>

#include "msgs/clock.hpp"
#include "msgs/stop_signal.hpp"

namespace stillframe::controller {

using stillframe_msgs::run_state_t;
using stillframe_msgs::timing_t;

namespace {

class LockStep {
 public:
  LockStep(ControllerLink& link, Answer& answer, timing_t& counters) noexcept
      : link_(link), answer_(answer), counters_(counters) {}

  /// Answers the measurement that link holds, or repeats the last command if it is that one again.
  void answer_measurement() noexcept {
    const std::int64_t seq = link_.measurement().seq;
    if (seq <= last_seq_) {
      ++counters_.n_duplicate;
      if (seq == last_seq_) link_.repeat_command();
      return;
    }
    const std::int64_t begin = monotonic_ns();
    answer_.answer(link_.measurement(), link_.command());
    const std::int64_t end = monotonic_ns();
    link_.publish_command();
    ++counters_.n_periods;
    counters_.worst_compute_ns = std::max(counters_.worst_compute_ns, end - begin);
    counters_.n_lost += seq - last_seq_ - 1;
    if (last_seq_ < 0) first_ns_ = begin;
    counters_.wall_time_ns = begin - first_ns_;
    last_seq_ = seq;
  }

  /// The end of the run if the plant has just told it.
  std::optional<Outcome> told_end() noexcept {
    const std::int32_t state = link_.plant_state().state;
    if (state == run_state_t::FAILED) return Outcome::plant_failed;
    if (state != run_state_t::ENDED) return std::nullopt;
    counters_.n_lost += std::max<std::int64_t>(link_.run_info().n_samples - 1 - last_seq_, 0);
    return Outcome::ended;
  }

 private:
  ControllerLink& link_;
  Answer& answer_;
  timing_t& counters_;
  std::int64_t last_seq_ = -1, first_ns_ = 0;
};

}  // namespace

Outcome run_lock_step(ControllerLink& link, Answer& answer, double timeout_s,
                      timing_t& counters) noexcept {
  LockStep run(link, answer, counters);
  const auto limit_ns = static_cast<std::int64_t>(timeout_s * ns_per_s);
  for (;;) {
    const Heard heard = link.take(look_every_ms);
    if (heard.measurement) run.answer_measurement();
    if (heard.run_state) {
      if (const auto end = run.told_end()) return *end;
    }
    if (stop_requested()) return Outcome::interrupted;
    if (monotonic_ns() - link.last_heard_ns() > limit_ns) return Outcome::silent;
  }
}

}  // namespace stillframe::controller
