#include "controller/wall_clock.hpp"

#include <algorithm>

#include "controller/server.hpp"
#include "msgs/clock.hpp"

namespace stillframe::controller {

namespace {

// Takes what has come, without waiting; io keeps the newest measurement. Bounded, so that a flood
// of messages costs lateness that is counted, and not a controller that never answers again.
Heard drain(LcmIo& io) noexcept {
  Heard all;
  for (int n = 0; n < 4096; ++n) {
    const Heard heard = io.take(0);
    if (!heard.message) break;
    all.measurement |= heard.measurement;
    all.run_state |= heard.run_state;
  }
  return all;
}

}  // namespace

Outcome run_wall_clock(LcmIo& io, Answer& answer, Deadlines deadlines, double timeout_s,
                       Counters& counters) noexcept {
  Server server(io, answer, timeout_s, counters);
  for (;;) {
    sleep_until(deadlines.next_ns());
    if (const auto end = server.broken_off()) return *end;
    const Deadlines::WakeUp wake_up = deadlines.wake_up(monotonic_ns());
    ++counters.n_periods;
    counters.n_late += wake_up.n_skipped;
    counters.worst_wake_up_ns = std::max(counters.worst_wake_up_ns, wake_up.late_ns);
    const Heard heard = drain(io);
    // The last measurement and the end may come in one period: the answer goes first.
    if (heard.measurement) server.answer_measurement();
    if (heard.run_state) {
      if (const auto end = server.told_end()) return *end;
    }
  }
}

}  // namespace stillframe::controller
