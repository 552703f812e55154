#include "tools/spacar/matlab_tokens.hpp"

#include <cctype>
#include <charconv>
#include <cmath>

#include "tools/spacar/place.hpp"
#include "tools/spacar/source_text.hpp"

namespace stillframe::tools::spacar {

namespace {

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\f");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t\f") - begin + 1);
}

class Tokenizer {
 public:
  Tokenizer(const std::vector<std::string>& lines, const std::string& name)
      : lines_(lines), name_(name) {}

  std::vector<Statement> all() {
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      line_ = static_cast<int>(i) + 1;
      if (!within_comment(trimmed(lines_[i]))) read_line(lines_[i]);
    }
    if (!brackets_.empty()) {
      refuse(name_, bracket_line_, std::string(1, brackets_.front()), "no end of it",
             "is a bracket that is closed");
    }
    finish();
    return std::move(statements_);
  }

 private:
  const std::vector<std::string>& lines_;
  const std::string& name_;
  std::vector<Statement> statements_;
  Statement now_;
  std::string brackets_;
  int bracket_line_ = 0, line_ = 0, comment_depth_ = 0;
  bool continues_ = false;

  bool within_comment(const std::string& line) {
    if (line == "%{" || line == "#{") ++comment_depth_;
    const bool within = comment_depth_ > 0;
    if (within && (line == "%}" || line == "#}")) --comment_depth_;
    return within;
  }

  bool in_matrix() const { return !brackets_.empty() && brackets_.back() != '('; }

  void add(TokenKind kind, const std::string& text, bool space_before, double number = 0) {
    if (now_.tokens.empty()) {
      now_.line = line_;
      now_.shown = shown(trimmed(lines_[static_cast<std::size_t>(line_ - 1)]));
    } else {
      now_.tokens.back().space_after = space_before;
    }
    now_.tokens.push_back({.kind = kind,
                           .text = text,
                           .number = number,
                           .line = line_,
                           .space_before = space_before});
  }

  void finish() {
    if (now_.tokens.empty()) return;
    add(TokenKind::end, "", true);
    statements_.push_back(std::move(now_));
    now_ = {};
  }

  void read_line(const std::string& text) {
    bool space = true;
    continues_ = false;
    for (std::size_t i = 0; i < text.size();) {
      const char c = text[i];
      if (c == ' ' || c == '\t' || c == '\f') {
        space = true;
        ++i;
        continue;
      }
      if (c == '%' || c == '#') break;
      if (text.compare(i, 3, "...") == 0) {
        continues_ = true;
        break;
      }
      i = read_token(text, i, space);
      space = false;
    }
    if (continues_) return;
    if (in_matrix()) {
      add(TokenKind::symbol, ";", true);
    } else if (brackets_.empty()) {
      finish();
    }
  }

  std::size_t read_token(const std::string& text, std::size_t i, bool space) {
    const char c = text[i];
    const bool number = is_digit(c) || (c == '.' && i + 1 < text.size() && is_digit(text[i + 1]));
    if (number) return read_number(text, i, space);
    if (is_letter(c)) {
      std::size_t end = i;
      while (end < text.size() && (is_letter(text[end]) || is_digit(text[end]))) ++end;
      add(TokenKind::name, text.substr(i, end - i), space);
      return end;
    }
    if (c == '"' || (c == '\'' && !is_transpose(space))) return read_text(text, i, space);
    if (brackets_.empty() && (c == ';' || c == ',')) {
      finish();
      return i + 1;
    }
    for (const char* two : {".*", "./", ".^", ".'", "==", "~=", "<=", ">=", "&&", "||"}) {
      if (text.compare(i, 2, two) != 0) continue;
      add(TokenKind::symbol, two, space);
      return i + 2;
    }
    add(TokenKind::symbol, std::string(1, c), space);
    follow_brackets(c);
    return i + 1;
  }

  void follow_brackets(char c) {
    if (c == '(' || c == '[' || c == '{') {
      if (brackets_.empty()) bracket_line_ = line_;
      brackets_ += c;
    } else if (c == ')' || c == ']' || c == '}') {
      const char open = c == ')' ? '(' : (c == ']' ? '[' : '{');
      if (brackets_.empty() || brackets_.back() != open) {
        refuse(name_, line_, std::string(1, c), "a bracket that nothing opens", "are pairs");
      }
      brackets_.pop_back();
    }
  }

  /// A quote behind an operand is a transpose; in a matrix a gap before it makes it a text.
  bool is_transpose(bool space) const {
    if (now_.tokens.empty()) return false;
    const Token& last = now_.tokens.back();
    const bool operand = last.kind == TokenKind::number || last.kind == TokenKind::name ||
                         last.text == ")" || last.text == "]" || last.text == "}" ||
                         last.text == "'";
    return operand && last.kind != TokenKind::text && !(space && in_matrix());
  }

  std::size_t read_text(const std::string& text, std::size_t i, bool space) {
    const char quote = text[i];
    std::string value;
    for (std::size_t j = i + 1; j < text.size(); ++j) {
      if (text[j] != quote) {
        value += text[j];
      } else if (j + 1 < text.size() && text[j + 1] == quote) {
        value += text[j++];
      } else {
        add(TokenKind::text, value, space);
        return j + 1;
      }
    }
    refuse(name_, line_, std::string(1, quote), "no end of the text", "is a text that is closed");
  }

  std::size_t read_number(const std::string& text, std::size_t i, bool space) {
    std::size_t end = i;
    while (end < text.size() && is_digit(text[end])) ++end;
    // The point of 1.*x and of 1./x belongs to the operator.
    const bool operation = end + 1 < text.size() && text[end] == '.' &&
                           std::string("*/^'").find(text[end + 1]) != std::string::npos;
    if (end < text.size() && text[end] == '.' && !operation) ++end;
    while (end < text.size() && is_digit(text[end])) ++end;
    if (end < text.size() && std::string("eEdD").find(text[end]) != std::string::npos) {
      std::size_t exponent = end + 1;
      if (exponent < text.size() && (text[exponent] == '+' || text[exponent] == '-')) ++exponent;
      if (exponent < text.size() && is_digit(text[exponent])) {
        end = exponent;
        while (end < text.size() && is_digit(text[end])) ++end;
      }
    }
    std::string word = text.substr(i, end - i);
    for (char& c : word) {
      if (c == 'd' || c == 'D') c = 'e';
    }
    double value = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || !std::isfinite(value)) {
      refuse(name_, line_, "number", "'" + shown(word) + "'", "is a finite number");
    }
    add(TokenKind::number, word, space, value);
    return end;
  }
};

}  // namespace

std::vector<Statement> statements_of(const std::vector<std::string>& lines,
                                     const std::string& name) {
  return Tokenizer(lines, name).all();
}

}  // namespace stillframe::tools::spacar
