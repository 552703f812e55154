#include "core/yaml/quoted.hpp"

#include <string_view>

namespace stillframe {

std::string quoted(const std::string& text) {
  constexpr std::string_view hexadecimal = "0123456789abcdef";
  std::string out = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20) {
      out += "\\x";
      out += hexadecimal[code / 16];
      out += hexadecimal[code % 16];
      continue;
    }
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

}  // namespace stillframe
