#include "msgs/identity.hpp"

#include <random>

namespace stillframe {

namespace {

std::int64_t random_up_to(std::int64_t largest) {
  std::random_device device;
  return std::uniform_int_distribution<std::int64_t>(1, largest)(device);
}

}  // namespace

std::int64_t new_instance() { return random_up_to((std::int64_t{1} << 53) - 1); }

std::int64_t new_run_id() { return random_up_to(999'999'999); }

}  // namespace stillframe
