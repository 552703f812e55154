#pragma once

#include <exception>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <string>

namespace stillframe {

/// The LCM provider to use: `given` if it is not empty, else the environment's LCM_DEFAULT_URL,
/// else udpm://239.255.76.67:7667?ttl=0, which never leaves the machine.
std::string lcm_url(const std::string& given);

/// Opens LCM. Errors: InputError with the commands that mend it if multicast is not routed.
std::unique_ptr<lcm::LCM> open_lcm(const std::string& url);

/// Waits up to timeout_ms for one message and handles it; a signal ends the wait early. Answers
/// whether a message was handled. hot: noexcept.
bool handle_one(lcm::LCM& lcm, int timeout_ms) noexcept;

/// Decodes a message, false if its bytes are not of that type. LCM runs handlers from C, which no
/// exception may cross, and a damaged message can make decode throw.
template <class Message>
bool decode(const lcm::ReceiveBuffer& buffer, Message& message) noexcept {
  try {
    return message.decode(buffer.data, 0, static_cast<int>(buffer.data_size)) >= 0;
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace stillframe
