#pragma once

#include <string>

namespace stillframe {

/// Text as a double-quoted value of YAML, whatever it has in it. Set-up.
std::string quoted(const std::string& text);

}  // namespace stillframe
