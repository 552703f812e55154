#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace stillframe::live {

enum class Style { plain, title, faint, good, warning, bad };

/// Lines of styled pieces. Set-up.
class StyledText {
 public:
  /// Adds a piece to the last line; printable() (core/files/utf8.hpp).
  StyledText& add(std::string_view text, Style style = Style::plain);
  void end_line();
  std::size_t n_lines() const { return lines_.size(); }

  /// Every line cut at width characters; only the first height lines unless height is 0.
  std::string print(int width, int height, bool colours) const;

 private:
  struct Piece {
    std::string text;
    Style style;
  };
  std::vector<std::vector<Piece>> lines_;
  std::vector<Piece> line_;
};

/// The number of characters of UTF-8 text.
int width_of(std::string_view text);

/// text with spaces behind it (left) or before it, so that it is width characters wide; longer text
/// is cut.
std::string padded(std::string_view text, int width, bool left = true);

}  // namespace stillframe::live
