#include "core/yaml/formula.hpp"

#include <charconv>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/errors/input_error.hpp"
#include "core/files/utf8.hpp"

namespace stillframe {

namespace {

/// Brackets nest no deeper than a formula is long.
constexpr std::size_t longest_formula = 400;

using Function = double (*)(double);
constexpr std::pair<std::string_view, Function> functions[] = {
    {"sqrt", [](double x) { return std::sqrt(x); }},
    {"sin", [](double x) { return std::sin(x); }},
    {"cos", [](double x) { return std::cos(x); }},
    {"tan", [](double x) { return std::tan(x); }},
    {"asin", [](double x) { return std::asin(x); }},
    {"acos", [](double x) { return std::acos(x); }},
    {"atan", [](double x) { return std::atan(x); }},
    {"exp", [](double x) { return std::exp(x); }},
    {"log", [](double x) { return std::log(x); }},
    {"abs", [](double x) { return std::abs(x); }},
};
constexpr std::pair<std::string_view, double> constants[] = {
    {"pi", std::numbers::pi},
    {"deg", std::numbers::pi / 180},
};

bool begins_name(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

class Formula {
 public:
  Formula(std::string_view text, const FormulaNames& names)
      : text_(text), rest_(text), names_(names) {}

  double value() {
    if (text_.size() > longest_formula) {
      throw InputError("found a formula of " + std::to_string(text_.size()) +
                       " characters, allowed are " + std::to_string(longest_formula));
    }
    const double result = sum();
    if (next() != '\0') fail("an operator");
    if (!std::isfinite(result)) throw InputError(shown() + " is no finite number");
    return result;
  }

 private:
  /// The next character that is no space, 0 at the end.
  char next() {
    while (!rest_.empty() && rest_.front() == ' ') rest_.remove_prefix(1);
    return rest_.empty() ? '\0' : rest_.front();
  }
  bool take(char c) {
    if (next() != c) return false;
    rest_.remove_prefix(1);
    return true;
  }

  double sum() {
    double value = product();
    for (;;) {
      if (take('+')) {
        value += product();
      } else if (take('-')) {
        value -= product();
      } else {
        return value;
      }
    }
  }

  double product() {
    double value = factor();
    for (;;) {
      if (take('*')) {
        value *= factor();
      } else if (take('/')) {
        value /= factor();
      } else {
        return value;
      }
    }
  }

  // As on paper: -2^2 is -4, 2^-1 is a half, and 2^3^2 is 2^9.
  double factor() {
    if (take('-')) return -factor();
    if (take('+')) return factor();
    const double base = primary();
    return take('^') ? std::pow(base, factor()) : base;
  }

  double primary() {
    const char c = next();
    if (take('(')) {
      const double value = sum();
      if (!take(')')) fail("')'");
      return value;
    }
    if (c == '#') return index();
    if (is_digit(c) || c == '.') return number();
    if (begins_name(c)) return named();
    fail("a number, a name or '('");
  }

  double number() {
    double value = 0;
    const auto [stop, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (error != std::errc()) fail("a number");
    rest_.remove_prefix(static_cast<std::size_t>(stop - rest_.data()));
    return value;
  }

  double index() {
    const std::size_t n = std::min(rest_.find_first_not_of('#'), rest_.size());
    const auto value = names_.index(n - 1);
    if (!value) {
      throw InputError(shown() + ": " + std::string(rest_.substr(0, n)) + " counts in " +
                       (n > 1 ? "repetitions inside each other" : "a repetition") +
                       " (repeat: N), and here is none");
    }
    rest_.remove_prefix(n);
    return *value;
  }

  double named() {
    std::size_t n = 1;
    while (n < rest_.size() && (begins_name(rest_[n]) || is_digit(rest_[n]))) ++n;
    const std::string name(rest_.substr(0, n));
    rest_.remove_prefix(n);
    for (const auto& [word, function] : functions) {
      if (word != name) continue;
      if (!take('(')) fail("'(' behind " + name);
      const double value = function(sum());
      if (!take(')')) fail("')'");
      return value;
    }
    for (const auto& [word, value] : constants) {
      if (word == name) return value;
    }
    const auto value = names_.variable(name);
    if (!value) {
      throw InputError(shown() + ": no variable above is called '" + printable(name, 40) +
                       "'; functions are " + formula_functions() + ", constants pi and deg");
    }
    return *value;
  }

  std::string shown() const { return "'=" + printable(text_, 80) + "'"; }

  [[noreturn]] void fail(const std::string& allowed) {
    const char c = next();
    const std::string found = c == '\0' ? "its end" : "'" + printable(rest_, 20) + "'";
    throw InputError(shown() + ": found " + found + ", allowed is " + allowed);
  }

  std::string_view text_, rest_;
  const FormulaNames& names_;
};

}  // namespace

double evaluate(std::string_view formula, const FormulaNames& names) {
  return Formula(formula, names).value();
}

bool is_variable_name(std::string_view name) {
  if (name.empty() || !begins_name(name.front())) return false;
  for (const char c : name) {
    if (!begins_name(c) && !is_digit(c)) return false;
  }
  for (const auto& [word, function] : functions) {
    if (word == name) return false;
  }
  for (const auto& [word, value] : constants) {
    if (word == name) return false;
  }
  return true;
}

std::string formula_functions() {
  std::string list;
  for (const auto& [word, function] : functions) {
    list += (list.empty() ? "" : ", ") + std::string(word);
  }
  return list;
}

}  // namespace stillframe
