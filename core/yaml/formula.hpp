#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace stillframe {

/// What a formula may name.
struct FormulaNames {
  /// The value of a variable, nothing if there is none of that name.
  std::function<std::optional<double>(const std::string& name)> variable;
  /// The number that '#' stands for, '##' at level 1 and so on; nothing outside a repetition.
  std::function<std::optional<double>(std::size_t level)> index;
};

/// The value of a formula: numbers, names, + - * / ^ and brackets, the functions of
/// formula_functions() in radians, and the constants pi and deg = pi / 180. Errors: InputError that
/// says what was found and what is allowed, without a place.
double evaluate(std::string_view formula, const FormulaNames& names);

/// Whether a variable may be called so: a word that no function and no constant has.
bool is_variable_name(std::string_view name);

std::string formula_functions();

}  // namespace stillframe
