#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace stillframe {

/// How many bytes the character of UTF-8 at the beginning has (text not empty), 0 if there is none.
/// Source: RFC 3629, section 4.
std::size_t utf8_length(std::string_view text);

/// Whether a byte goes on with a character rather than begins one.
constexpr bool continues_character(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0) == 0x80;
}

/// The text with U+FFFD for each byte that is no UTF-8.
std::string as_utf8(std::string_view text);

/// Whether it begins with a character that a terminal obeys rather than shows: C0, delete, and C1
/// (two bytes in UTF-8). Text not empty.
bool is_control(std::string_view text);

/// Text from a file or a bus on one line of a terminal: control characters and bytes that are no
/// UTF-8 as \xNN, and cut between two characters, with "..." in its place, where it is longer than
/// `longest` bytes. Set-up.
std::string printable(std::string_view text, std::size_t longest = std::string_view::npos);

}  // namespace stillframe
