#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>

// Options of programs that are numbers. CLI11's own checks let NaN and infinity pass.
namespace stillframe {

namespace detail {

inline CLI::Validator finite_number(const char* name, bool zero) {
  return CLI::Validator(
      [zero](std::string& text) -> std::string {
        double value = 0;
        if (CLI::detail::lexical_cast(text, value) && std::isfinite(value) &&
            (zero ? value >= 0 : value > 0)) {
          return {};
        }
        return "'" + text + "' is no number " + (zero ? "of 0 or more" : "above 0");
      },
      name);
}

}  // namespace detail

inline CLI::Validator positive_number() { return detail::finite_number("POSITIVE", false); }
inline CLI::Validator number_from_zero() { return detail::finite_number("NONNEGATIVE", true); }

}  // namespace stillframe
