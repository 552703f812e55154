#pragma once

#include <yaml-cpp/mark.h>

#include <optional>
#include <string>
#include <vector>

namespace stillframe {

/// A text written out: YAML, and where what begins on each line of it was written.
struct WrittenOut {
  std::string text;
  std::vector<YAML::Mark> marks;
};

/// Writes out what a file says once for many places: `variables`, formulas ('=' before them), polar
/// positions, and `repeat` with '#' for its count, turned `about` an axis (docs/scene.md,
/// "Shorthand"). Nothing where a text has none of these. text: what load_yaml accepts. Errors:
/// InputError "file:line:column: ...".
std::optional<WrittenOut> write_out(const std::string& text, const std::string& source_name);

}  // namespace stillframe
