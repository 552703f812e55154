#include "msgs/lcm_bus.hpp"

#include <poll.h>

#include <cstdlib>

#include "core/yaml/input_error.hpp"

namespace stillframe {

std::string lcm_url(const std::string& given) {
  if (!given.empty()) return given;
  const char* environment = std::getenv("LCM_DEFAULT_URL");
  return environment != nullptr && *environment != '\0' ? environment
                                                        : "udpm://239.255.76.67:7667?ttl=0";
}

std::unique_ptr<lcm::LCM> open_lcm(const std::string& url) {
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

bool handle_one(lcm::LCM& lcm, int timeout_ms) noexcept {
  pollfd ready{.fd = lcm.getFileno(), .events = POLLIN, .revents = 0};
  return poll(&ready, 1, timeout_ms) > 0 && lcm.handle() == 0;
}

}  // namespace stillframe
