#pragma once

#include <yaml-cpp/mark.h>

#include <string>
#include <vector>

namespace stillframe {

/// A YAML value that may be built anew and still knows where each part of it was written.
struct YamlTree {
  enum class Kind { null, scalar, sequence, map };

  YAML::Mark mark;
  Kind kind = Kind::null;
  std::string text = {};            ///< of a scalar
  std::vector<YamlTree> keys = {};  ///< of a map: scalars, one for each child
  std::vector<YamlTree> children = {};

  bool is_map() const { return kind == Kind::map; }
  bool is_sequence() const { return kind == Kind::sequence; }
  bool is_scalar() const { return kind == Kind::scalar; }
  /// The value of a key of this map, or null.
  const YamlTree* find(const std::string& key) const;
};

/// Of a text that load_yaml accepts.
YamlTree read_tree(const std::string& text);

/// YAML of which every key and every value begins on a line of its own; marks becomes where what
/// begins on each line was written.
std::string text_of(const YamlTree& tree, std::vector<YAML::Mark>& marks);

}  // namespace stillframe
