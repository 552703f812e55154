#pragma once

#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <string>
#include <string_view>

#include "msgs/message_fit.hpp"

namespace stillframe {

/// The LCM provider to use: `given` if it is not empty, else the environment's LCM_DEFAULT_URL,
/// else udpm://239.255.76.67:7667?ttl=0, which never leaves the machine.
std::string lcm_url(const std::string& given);

/// Opens LCM. Errors: InputError with the commands that mend it if multicast is not routed.
std::unique_ptr<lcm::LCM> open_lcm(const std::string& url);

/// Makes LCM hear from now on, which it otherwise begins with the first subscription and without a
/// word if it cannot. Errors: InputError.
void require_hearing(lcm::LCM& lcm);
/// Throws what require_hearing would.
[[noreturn]] void refuse_deaf();

/// Waits up to timeout_ms for one message and handles it; a signal ends the wait early. Answers
/// whether a message was handled. hot: noexcept.
bool handle_one(lcm::LCM& lcm, int timeout_ms) noexcept;

/// The bytes of a message as it came.
inline std::string_view bytes_of(const lcm::ReceiveBuffer& buffer) noexcept {
  return {static_cast<const char*>(buffer.data), buffer.data_size};
}

/// The same the other way, for handlers.
inline lcm::ReceiveBuffer buffer_of(std::string_view bytes) noexcept {
  return {const_cast<char*>(bytes.data()), static_cast<std::uint32_t>(bytes.size()), 0};
}

/// Decodes a message, false if its bytes are not of that type. LCM runs handlers from C, which no
/// exception may cross.
template <class Message>
bool decode(const lcm::ReceiveBuffer& buffer, Message& message) noexcept {
  return decode(bytes_of(buffer), message);
}

}  // namespace stillframe
