#pragma once

#include <string>

namespace YAML {
class Node;
struct Mark;
}  // namespace YAML

namespace stillframe {

/// What a YAML text may be made of, far beyond any scene, gains or policy: a thousand flexible
/// beams need a tenth of it. A tree of so many values takes some 100 MB.
inline constexpr std::size_t most_yaml_bytes = std::size_t{4} << 20;
inline constexpr std::size_t most_yaml_values = 300'000;
inline constexpr std::size_t most_yaml_depth = 32;
inline constexpr std::size_t longest_yaml_key = 200;

/// The one way from text to a YAML tree. The text is gone through before any of it is kept, so that
/// what it says of itself is never believed: no anchors and aliases, which may stand for more than
/// there is memory (or for themselves), no tags, one document, bounded in size, number of values
/// and depth, printable UTF-8, and no key twice in one map. source_name stands for the file in
/// messages. Set-up. Errors: InputError "file:line:column: key: ...".
YAML::Node load_yaml(const std::string& text, const std::string& source_name);

/// "file:line:column", or the file alone for a mark that is nowhere.
std::string place_of(const std::string& file, const YAML::Mark& mark);

}  // namespace stillframe
