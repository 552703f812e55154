#include "core/files/utf8.hpp"

#include <algorithm>

#include "core/errors/formatted.hpp"

namespace stillframe {

std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  for (std::size_t i = 1; i < length; ++i) {
    if (byte(i) < 0x80 || byte(i) > 0xBF) return 0;
  }
  // Longer than it need be, a half of a pair of UTF-16, or beyond U+10FFFF.
  const bool impossible = (first == 0xE0 && byte(1) < 0xA0) || (first == 0xED && byte(1) > 0x9F) ||
                          (first == 0xF0 && byte(1) < 0x90) || (first == 0xF4 && byte(1) > 0x8F);
  return impossible ? 0 : length;
}

std::string as_utf8(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    out += length > 0 ? text.substr(0, length) : std::string_view("\xEF\xBF\xBD");
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

bool is_control(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  if (first < 0x20 || first == 0x7F) return true;
  return first == 0xC2 && text.size() > 1 && static_cast<unsigned char>(text[1]) < 0xA0;
}

std::string printable(std::string_view text, std::size_t longest) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text), n_bytes = std::max<std::size_t>(length, 1);
    const bool shown = length > 0 && !is_control(text);
    // What is not shown takes four letters a byte.
    if (out.size() + (shown ? 1 : 4) * n_bytes > longest) return out + "...";
    for (std::size_t i = 0; i < n_bytes; ++i) {
      const auto byte = static_cast<unsigned char>(text[i]);
      out += shown ? std::string(1, text[i]) : formatted("\\x%02x", static_cast<unsigned>(byte));
    }
    text.remove_prefix(n_bytes);
  }
  return out;
}

}  // namespace stillframe
