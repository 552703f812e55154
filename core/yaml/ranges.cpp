#include "core/yaml/ranges.hpp"

#include <limits>

#include "core/files/utf8.hpp"

namespace stillframe {

namespace {

/// They say their own bounds.
constexpr double any = std::numeric_limits<double>::infinity();

[[noreturn]] void refuse(const YamlReader& value, const std::string& allowed) {
  value.fail("found '" + printable(value.text(), 80) + "', allowed is " + allowed);
}

}  // namespace

double number_within(const YamlReader& value, double lowest, double highest) {
  const double number = value.number(any);
  if (number >= lowest && number <= highest) return number;
  refuse(value, "a number from " + shortest_digits(lowest) + " to " + shortest_digits(highest));
}

double positive_up_to(const YamlReader& value, double highest) {
  const double number = value.number(any);
  if (number > 0 && number <= highest) return number;
  refuse(value, "a number above 0 and up to " + shortest_digits(highest));
}

std::int64_t integer_within(const YamlReader& value, std::int64_t lowest, std::int64_t highest) {
  const std::int64_t number = value.integer(lowest);
  if (number <= highest) return number;
  refuse(value, "a whole number from " + std::to_string(lowest) + " to " + std::to_string(highest));
}

}  // namespace stillframe
