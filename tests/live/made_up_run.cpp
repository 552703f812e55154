#include <cstdlib>
#include <iostream>

#include "msgs/stop_signal.hpp"
#include "tests/live/bus_plant.hpp"

// made_up_run RUN_ID FIRST: a run on the bus until SIGTERM, for tests of programs in other
// languages.
int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "made_up_run RUN_ID FIRST\n";
    return 2;
  }
  stillframe::catch_stop_signals();
  const stillframe::live::sample::BusPlant plant(std::atoll(argv[1]), std::atoll(argv[2]), true);
  while (!stillframe::stop_requested()) {
    stillframe::sleep_until(stillframe::monotonic_ns() + 20'000'000);
  }
}
