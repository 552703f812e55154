#pragma once

#include <string>
#include <string_view>

namespace stillframe {

/// Text from a file or a bus as a terminal may have it: control characters, those of two bytes
/// among them, and bytes that are no UTF-8 become '?'. Set-up.
std::string printable(std::string_view text);

}  // namespace stillframe
