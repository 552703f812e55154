#pragma once

#include <exception>
#include <string_view>

namespace stillframe {

/// What the bytes of a payload are to a type of message.
enum class Fit {
  whole,          ///< one message, every length in it within the payload
  other_version,  ///< one of another version of the type: another fingerprint
  damaged,        ///< anything else
};

/// Whether a payload is one whole message of a type of msgs/, without decoding it. The decoders of
/// lcm-gen believe every length they read, so nothing is decoded that has not passed here.
/// Hot: noexcept, no allocation.
template <typename Message>
Fit fit(std::string_view payload) noexcept;

/// The message of type Message in a payload, of bus or log. False if the bytes are not one whole
/// message, or memory has run out.
template <typename Message>
bool decode(std::string_view payload, Message& message) noexcept try {
  if (fit<Message>(payload) != Fit::whole) return false;
  // lcm-gen's decoders leave a list of no entries as it was.
  message = Message();
  const auto size = static_cast<int>(payload.size());
  return message.decode(payload.data(), 0, size) == size;
} catch (const std::exception&) {
  return false;
}

}  // namespace stillframe
