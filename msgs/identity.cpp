#include "msgs/identity.hpp"

#include <fstream>
#include <functional>
#include <random>
#include <string>

namespace stillframe {

namespace {

std::int64_t random_up_to(std::int64_t largest) {
  std::random_device device;
  return std::uniform_int_distribution<std::int64_t>(1, largest)(device);
}

constexpr std::uint64_t n_clocks = std::uint64_t{1} << (53 - bits_below_clock);

/// A number for the clock of this process, 1 to n_clocks - 1. Where the system does not say which
/// it is, one of this process alone: it then asks others for theirs, which is never wrong.
std::int64_t own_clock() {
  std::string boot;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), boot);
  if (boot.empty()) return random_up_to(static_cast<std::int64_t>(n_clocks) - 1);
  // By their numbers namespaces are told apart only while they live. A kernel without them has one
  // clock.
  std::ifstream offsets("/proc/self/timens_offsets");
  for (std::string line; std::getline(offsets, line);) boot += line;
  return 1 + static_cast<std::int64_t>(std::hash<std::string>{}(boot) % (n_clocks - 1));
}

}  // namespace

std::int64_t new_instance() {
  static const std::int64_t clock = own_clock();
  return clock << bits_below_clock | random_up_to((std::int64_t{1} << bits_below_clock) - 1);
}

std::int64_t new_run_id() { return random_up_to(999'999'999); }

}  // namespace stillframe
