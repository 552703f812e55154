#include "controller/lock_step.hpp"

#include "controller/server.hpp"

namespace stillframe::controller {

namespace {

constexpr int wait_ms = 50;  // between looks at the clock and the stop signal

}  // namespace

Outcome run_lock_step(LcmIo& io, Answer& answer, double timeout_s, Counters& counters) noexcept {
  Server server(io, answer, timeout_s, counters);
  for (;;) {
    const Heard heard = io.take(wait_ms);
    if (heard.measurement) {
      const std::int64_t duplicates = counters.n_duplicate;
      server.answer_measurement();
      if (counters.n_duplicate == duplicates) ++counters.n_periods;
    }
    if (heard.run_state) {
      if (const auto end = server.told_end()) return *end;
    }
    if (const auto end = server.broken_off()) return *end;
  }
}

}  // namespace stillframe::controller
