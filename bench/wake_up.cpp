// How late a bare periodic loop wakes up: the floor for any loop of this machine, and what memory
// locking, timer slack and idle states of the processor have to do with it.
#include <fcntl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "bench/times.hpp"
#include "core/cli/command.hpp"
#include "msgs/clock.hpp"

namespace {

struct Options {
  int priority = 49;
  double rate_hz = 1000, duration_s = 5;
  bool lock = false, fine_timers = false, awake = false;
  std::string out;
};

void measure(const Options& options, stillframe::Times& late) {
  using namespace stillframe;
  const auto period = static_cast<std::int64_t>(1e9 / options.rate_hz);
  const auto n = static_cast<std::int64_t>(options.rate_hz * options.duration_s);
  std::int64_t next = monotonic_ns() + period;
  for (std::int64_t k = 0; k < n; ++k) {
    sleep_until(next);
    const std::int64_t now = monotonic_ns();
    late.add(now - next);
    next += period;
    while (next < now) next += period;
  }
}

}  // namespace

int main(int argc, char** argv) try {
  Options options;
  stillframe::cli::Command app("Wake-up latency of a bare loop on CLOCK_MONOTONIC.");
  app.option("--priority", options.priority, "SCHED_FIFO priority, 0: ordinary thread");
  app.option("--rate", options.rate_hz, "Hz");
  app.option("--duration", options.duration_s, "s");
  app.flag("--lock", options.lock, "mlockall");
  app.flag("--fine-timers", options.fine_timers, "timer slack of 1 ns");
  app.flag("--awake", options.awake, "0 us into /dev/cpu_dma_latency");
  app.option("--out", options.out, "file for lines of time (ns) and count");
  if (const auto code = app.parse(argc, argv)) return *code;
  stillframe::Times late(static_cast<std::size_t>(options.rate_hz * options.duration_s) + 1);
  if (options.lock && mlockall(MCL_CURRENT | MCL_FUTURE) != 0) perror("mlockall");
  if (options.fine_timers) prctl(PR_SET_TIMERSLACK, 1UL);
  if (options.awake) {
    const int file = open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
    const std::int32_t none = 0;
    if (file < 0 || write(file, &none, sizeof none) != sizeof none) perror("/dev/cpu_dma_latency");
  }
  stillframe::use_fifo(options.priority);
  measure(options, late);
  if (!options.out.empty()) {
    late.write(options.out);
    return 0;
  }
  stillframe::Times::print_head("wake-up after the deadline");
  late.print_row("bare loop");
} catch (const std::exception& error) {
  std::fprintf(stderr, "bench_wake_up: %s\n", error.what());
  return 4;
}
