#include "msgs/lcm_bus.hpp"

#include <poll.h>

#include <cstdlib>
#include <stdexcept>

#include "core/errors/input_error.hpp"
#include "msgs/lcm_guard.hpp"

namespace stillframe {

std::string lcm_url(const std::string& given) {
  if (!given.empty()) return given;
  const char* environment = std::getenv("LCM_DEFAULT_URL");
  return environment != nullptr && *environment != '\0' ? environment
                                                        : "udpm://239.255.76.67:7667?ttl=0";
}

std::unique_ptr<lcm::LCM> open_lcm(const std::string& url) {
  if (!lcm_is_guarded()) throw std::logic_error("liblcm's socket would be open to any packet");
  auto lcm = std::make_unique<lcm::LCM>(url);
  if (!lcm->good()) {
    throw InputError(
        "LCM cannot be opened at '" + url +
        "'; allowed is a provider as in udpm://239.255.76.67:7667?ttl=0. If multicast has no "
        "route, either run inside a private network, scripts/private_network COMMAND, or give "
        "it one: sudo ip link set lo multicast on; sudo ip route add 224.0.0.0/4 dev lo");
  }
  return lcm;
}

void require_hearing(lcm::LCM& lcm) {
  if (lcm.getFileno() < 0) refuse_deaf();
}

void refuse_deaf() {
  throw InputError(
      "LCM opened, and cannot hear: it got no socket, pipe or thread; see `ulimit -n` (files that "
      "a "
      "process may open) and `ulimit -u`");
}

bool handle_one(lcm::LCM& lcm, int timeout_ms) noexcept {
  pollfd ready{.fd = lcm.getFileno(), .events = POLLIN, .revents = 0};
  return poll(&ready, 1, timeout_ms) > 0 && lcm.handle() == 0;
}

}  // namespace stillframe
