#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace stillframe {

/// A finite number that is all of a text, written as YAML has it; nothing for any other text.
inline std::optional<double> to_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const char* end = text.data() + text.size();
  double value = 0;
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace stillframe
