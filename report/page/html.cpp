#include "report/page/html.hpp"

#include <cmath>
#include <cstdlib>

#include "core/errors/formatted.hpp"
#include "core/files/utf8.hpp"

namespace stillframe::page {

namespace {

constexpr std::string_view replacement = "\xEF\xBF\xBD";

std::string_view escaped_ascii(char character) {
  switch (character) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    default:
      return {};
  }
}

std::string with_minus_signs(std::string_view text) {
  std::string result;
  for (const char character : text) {
    if (character == '-') {
      result += "\u2212";
    } else {
      result += character;
    }
  }
  return result;
}

std::string superscript(int exponent) {
  static constexpr const char* digits[] = {"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                           "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  std::string text;
  for (const char character : std::to_string(exponent)) {
    text += character == '-' ? "\u207b" : digits[character - '0'];
  }
  return text;
}

bool is_no_text(char character) {
  const auto code = static_cast<unsigned char>(character);
  return (code < 0x20 && character != '\n' && character != '\t') || code == 0x7F;
}

}  // namespace

std::string escape(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0 || is_no_text(text.front())) {
      result += replacement;
    } else if (const std::string_view safe = escaped_ascii(text.front()); !safe.empty()) {
      result += safe;
    } else {
      result += text.substr(0, length);
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return result;
}

std::string element(std::string_view name, Attributes attributes, std::string_view content) {
  std::string result = "<" + std::string(name);
  for (const auto& [key, value] : attributes) {
    if (value.empty()) continue;
    result += " " + std::string(key) + "=\"" + escape(value) + "\"";
  }
  return result + ">" + std::string(content) + "</" + std::string(name) + ">\n";
}

std::string text_element(std::string_view name, Attributes attributes, std::string_view text) {
  return element(name, attributes, escape(text));
}

std::string number_text(double value, int digits) {
  if (!std::isfinite(value)) return "\u2013";
  if (value == 0) return "0";
  // Rounded first, so that 999.96 has the digits of 1000.
  std::string text = formatted("%.*e", digits - 1, value);
  const int exponent = std::atoi(text.c_str() + text.find('e') + 1);
  if (exponent >= -3 && exponent < 6) {
    text = formatted("%.*f", std::max(0, digits - 1 - exponent), value);
  }
  text = with_minus_signs(text);
  const std::size_t end = text.find('e');
  return end == std::string::npos ? text : text.substr(0, end) + "\u00b710" + superscript(exponent);
}

std::string short_number(double value) {
  if (!std::isfinite(value)) return number_text(value);
  return with_minus_signs(formatted("%.6g", value));
}

}  // namespace stillframe::page
