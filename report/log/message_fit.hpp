#pragma once

#include <string_view>

namespace stillframe::report {

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

}  // namespace stillframe::report
