#include "core/files/printable_lines.hpp"

#include <string_view>

#include "core/files/utf8.hpp"

namespace stillframe {

PrintableLines::int_type PrintableLines::overflow(int_type character) {
  if (traits_type::eq_int_type(character, traits_type::eof()))
    return traits_type::not_eof(character);
  const char c = traits_type::to_char_type(character);
  return xsputn(&c, 1) == 1 ? character : traits_type::eof();
}

std::streamsize PrintableLines::xsputn(const char* text, std::streamsize n) {
  for (std::streamsize i = 0; i < n; ++i) {
    if (text[i] != '\n' && text[i] != '\t') {
      line_ += text[i];
    } else if (!give_line() ||
               traits_type::eq_int_type(behind_.sputc(text[i]), traits_type::eof())) {
      return i;
    }
  }
  return n;
}

int PrintableLines::sync() { return give_line() ? behind_.pubsync() : -1; }

bool PrintableLines::give_line() {
  const std::string clean = printable(line_);
  line_.clear();
  const auto size = static_cast<std::streamsize>(clean.size());
  return behind_.sputn(clean.data(), size) == size;
}

}  // namespace stillframe
