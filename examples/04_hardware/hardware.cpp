// The loop on a rig of one's own, until it is active.
#include <iostream>

#include "controller/gains.hpp"
#include "controller/loop.hpp"
#include "controller/start_check.hpp"
#include "rig_io.hpp"

using namespace stillframe::controller;

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: hardware GAINS\n";
    return 2;
  }
  const Gains gains = read_gains(argv[1]);
  require_stable(gains);
  require_stable_ramp(gains);
  Cards cards(gains.legs.size());
  const std::int64_t start = cards.now_ns();
  RigIo io(cards, gains.sample_rate_hz, start);

  const Policy policy = default_policy(gains.sample_rate_hz);  // or read_policy of a file
  const Supervisor supervisor(gains, policy, true);
  Loop loop(io, supervisor, policy,
            {.sample_rate_hz = gains.sample_rate_hz, .phase = 0, .start_ns = start});
  while (loop.counters().state != State::active && loop.counters().n_periods < 10'000) {
    cards.wait_until(loop.next_ns());
    loop.period(cards.now_ns());
  }
  std::cout << to_text(loop.counters().state) << " after " << loop.counters().n_answered
            << " measurements, " << loop.counters().n_late << " periods late\n";
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 2;
}
