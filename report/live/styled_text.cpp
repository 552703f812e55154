#include "report/live/styled_text.hpp"

#include <algorithm>

#include "core/files/utf8.hpp"

namespace stillframe::live {

namespace {

std::string first_characters(std::string_view text, int n) {
  std::size_t at = 0;
  for (; at < text.size(); ++at) {
    if (!continues_character(text[at]) && n-- == 0) break;
  }
  return std::string(text.substr(0, at));
}

const char* code_of(Style style) {
  switch (style) {
    case Style::plain:
      return "";
    case Style::title:
      return "\033[1m";
    case Style::faint:
      return "\033[2m";
    case Style::good:
      return "\033[32m";
    case Style::warning:
      return "\033[33m";
    case Style::bad:
      return "\033[31m";
  }
  return "";
}

}  // namespace

int width_of(std::string_view text) {
  return static_cast<int>(
      std::count_if(text.begin(), text.end(), [](char c) { return !continues_character(c); }));
}

std::string padded(std::string_view text, int width, bool left) {
  const std::string clean = first_characters(printable(text), std::max(width, 0));
  const std::string space(static_cast<std::size_t>(std::max(width - width_of(clean), 0)), ' ');
  return left ? clean + space : space + clean;
}

StyledText& StyledText::add(std::string_view text, Style style) {
  line_.push_back({printable(text), style});
  return *this;
}

void StyledText::end_line() {
  lines_.push_back(std::move(line_));
  line_.clear();
}

std::string StyledText::print(int width, int height, bool colours) const {
  std::string out;
  const std::size_t most = height > 0 ? static_cast<std::size_t>(height) : lines_.size();
  for (std::size_t i = 0; i < std::min(most, lines_.size()); ++i) {
    int left = width;
    std::string line;
    for (const Piece& piece : lines_[i]) {
      const std::string text = first_characters(piece.text, left);
      left -= width_of(text);
      const bool styled = colours && piece.style != Style::plain && !text.empty();
      line += styled ? code_of(piece.style) + text + "\033[0m" : text;
    }
    if (!colours) line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

}  // namespace stillframe::live
