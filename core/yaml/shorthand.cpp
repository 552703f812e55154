#include "core/yaml/shorthand.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "core/errors/input_error.hpp"
#include "core/files/utf8.hpp"
#include "core/yaml/formula.hpp"
#include "core/yaml/load.hpp"
#include "core/yaml/reader.hpp"
#include "core/yaml/to_number.hpp"
#include "core/yaml/tree.hpp"
#include "core/yaml/turned.hpp"

namespace stillframe {

namespace {

using Kind = YamlTree::Kind;

constexpr int most_repetitions = 10000;

class Shorthand {
 public:
  explicit Shorthand(const std::string& file) : file_(file) {}

  YamlTree written_out(YamlTree root) {
    if (root.is_map()) {
      const YamlTree* planar = root.find("planar");
      is_planar_ = planar != nullptr && planar->text == "true";
      take_variables(root);
    }
    YamlTree result = value(root);
    for (const auto& [name, variable] : variables_) {
      if (!variable.is_used) fail(variable.mark, "variables." + name + ": nothing uses it");
    }
    return result;
  }

  /// Whether there was anything to write out.
  bool has_any() const { return has_any_; }

 private:
  struct Variable {
    double value;
    YAML::Mark mark;
    bool is_used = false;
  };

  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& message) const {
    throw InputError(place_of(file_, mark) + ": " + message);
  }

  void take_variables(YamlTree& root) {
    for (std::size_t i = 0; i < root.keys.size(); ++i) {
      if (root.keys[i].text != "variables") continue;
      has_any_ = true;
      const YamlTree map = root.children[i];
      root.keys.erase(root.keys.begin() + static_cast<std::ptrdiff_t>(i));
      root.children.erase(root.children.begin() + static_cast<std::ptrdiff_t>(i));
      if (!map.is_map()) fail(map.mark, "variables: allowed is a map, as in {radius: 0.6}");
      for (std::size_t k = 0; k < map.keys.size(); ++k) {
        take_variable(map.keys[k], map.children[k]);
      }
      return;
    }
  }

  void take_variable(const YamlTree& key, const YamlTree& given) {
    const std::string name = "variables." + printable(key.text, longest_yaml_key);
    if (!is_variable_name(key.text)) {
      fail(key.mark, name + ": allowed is a word of letters, digits and _ that is none of " +
                         formula_functions() + ", pi, deg");
    }
    const YamlTree found = value(given);
    const auto number = found.is_scalar() ? to_number(found.text) : std::nullopt;
    if (!number) {
      fail(given.mark, name + ": found " +
                           (found.is_scalar() ? "'" + printable(found.text, 80) + "'"
                                              : std::string("no number")) +
                           ", allowed is a number, or a formula as in =2*radius");
    }
    variables_.emplace(key.text, Variable{*number, key.mark});
  }

  /// A value as it reads at this place of the repetitions around it.
  YamlTree value(const YamlTree& tree) {
    if (++n_values_ > most_yaml_values) {
      fail(tree.mark,
           "found more than " + std::to_string(most_yaml_values) + " values with all repetitions");
    }
    switch (tree.kind) {
      case Kind::null:
        return tree;
      case Kind::scalar:
        return scalar(tree);
      case Kind::sequence:
        return sequence(tree);
      case Kind::map:
        return tree.find("angle_deg") ? polar(tree) : map(tree);
    }
    return tree;
  }

  YamlTree scalar(const YamlTree& tree) {
    YamlTree result = tree;
    if (tree.text.starts_with('=')) {
      has_any_ = true;
      const double found = formula(tree);
      result.text = shortest_digits(found + 0.0);
    } else {
      result.text = counted(tree);
    }
    return result;
  }

  double formula(const YamlTree& tree) {
    const FormulaNames names{[&](const std::string& name) -> std::optional<double> {
                               const auto found = variables_.find(name);
                               if (found == variables_.end()) return std::nullopt;
                               found->second.is_used = true;
                               return found->second.value;
                             },
                             [&](std::size_t level) -> std::optional<double> {
                               if (level >= counts_.size()) return std::nullopt;
                               return counts_[counts_.size() - 1 - level];
                             }};
    try {
      return evaluate(std::string_view(tree.text).substr(1), names);
    } catch (const InputError& error) {
      fail(tree.mark, error.what());
    }
  }

  /// A text with the counts of the repetitions in the place of '#', '##' and so on.
  std::string counted(const YamlTree& tree) const {
    if (counts_.empty()) return tree.text;
    std::string text;
    for (std::size_t i = 0; i < tree.text.size();) {
      const std::size_t n = std::min(tree.text.find_first_not_of('#', i), tree.text.size()) - i;
      if (n == 0) {
        text += tree.text[i++];
        continue;
      }
      if (n > counts_.size()) {
        fail(tree.mark, "found '" + printable(tree.text, 80) + "' in " +
                            std::to_string(counts_.size()) + " repetitions inside each other");
      }
      text += std::to_string(counts_[counts_.size() - n]);
      i += n;
    }
    return text;
  }

  YamlTree polar(const YamlTree& tree) {
    has_any_ = true;
    double radius = 0, angle = 0, z = 0;
    bool has_radius = false, has_z = false;
    for (std::size_t i = 0; i < tree.keys.size(); ++i) {
      const std::string& key = tree.keys[i].text;
      if (key != "radius" && key != "angle_deg" && (key != "z" || is_planar_)) {
        fail(tree.keys[i].mark,
             printable(key, 60) + ": unknown key of a polar position; allowed: radius, angle_deg" +
                 (is_planar_ ? "" : ", z"));
      }
      const YamlTree found = value(tree.children[i]);
      const auto number = found.is_scalar() ? to_number(found.text) : std::nullopt;
      if (!number) fail(tree.children[i].mark, key + ": allowed is a number");
      (key == "radius" ? radius : key == "z" ? z : angle) = *number;
      has_radius = has_radius || key == "radius";
      has_z = has_z || key == "z";
    }
    if (!has_radius) fail(tree.mark, "a polar position needs a radius");
    if (!has_z && !is_planar_) fail(tree.mark, "a polar position needs z, in m");
    const Turn turn = turn_of_degrees(angle);
    YamlTree result{.mark = tree.mark, .kind = Kind::sequence};
    for (const double part : {radius * turn.cos, radius * turn.sin, z}) {
      result.children.push_back(
          {.mark = tree.mark, .kind = Kind::scalar, .text = shortest_digits(part + 0.0)});
    }
    if (is_planar_) result.children.pop_back();
    return result;
  }

  YamlTree sequence(const YamlTree& tree) {
    YamlTree result{.mark = tree.mark, .kind = Kind::sequence};
    for (const YamlTree& item : tree.children) {
      if (!item.is_map() || !item.find("repeat")) {
        result.children.push_back(value(item));
        continue;
      }
      const Repetition repetition = repetition_of(item);
      const YamlTree* of = repetition.what.find("of");
      if (of != nullptr && (repetition.what.keys.size() > 1 || !of->is_sequence())) {
        fail(of->mark, "of: allowed is a sequence of what is repeated, beside repeat and about");
      }
      repeat(repetition, [&] {
        YamlTree part = value(of != nullptr ? *of : repetition.what);
        turn(part, repetition);
        if (of == nullptr) {
          result.children.push_back(std::move(part));
        } else {
          std::move(part.children.begin(), part.children.end(),
                    std::back_inserter(result.children));
        }
      });
    }
    return result;
  }

  YamlTree map(const YamlTree& tree) {
    YamlTree result{.mark = tree.mark, .kind = Kind::map};
    std::set<std::string> names;
    const auto add = [&](const YamlTree& key, YamlTree entry) {
      if (!names.insert(key.text).second) {
        fail(key.mark, printable(key.text, longest_yaml_key) +
                           ": this key comes twice; in a repetition a name has a # for its count");
      }
      result.keys.push_back(key);
      result.children.push_back(std::move(entry));
    };
    for (std::size_t i = 0; i < tree.keys.size(); ++i) {
      const YamlTree &key = tree.keys[i], &entry = tree.children[i];
      if (!entry.is_map() || !entry.find("repeat")) {
        YamlTree name = key;
        name.text = counted(key);
        add(name, value(entry));
        continue;
      }
      const Repetition repetition = repetition_of(entry);
      repeat(repetition, [&] {
        YamlTree name = key;
        name.text = counted(key);
        YamlTree part = value(repetition.what);
        turn(part, repetition);
        add(name, std::move(part));
      });
    }
    return result;
  }

  struct Repetition {
    int n = 1;
    char axis = 0;  ///< 0: not turned
    YamlTree what;  ///< without `repeat` and `about`
  };

  Repetition repetition_of(const YamlTree& tree) {
    has_any_ = true;
    Repetition repetition;
    repetition.what = {.mark = tree.mark, .kind = Kind::map};
    for (std::size_t i = 0; i < tree.keys.size(); ++i) {
      const YamlTree &key = tree.keys[i], &entry = tree.children[i];
      if (key.text == "repeat") {
        const YamlTree found = value(entry);
        const auto n = found.is_scalar() ? to_number(found.text) : std::nullopt;
        if (!n || *n != std::round(*n) || *n < 1 || *n > most_repetitions) {
          fail(entry.mark, "repeat: found '" + printable(found.text, 80) +
                               "', allowed is a whole number from 1 to " +
                               std::to_string(most_repetitions));
        }
        repetition.n = static_cast<int>(*n);
      } else if (key.text == "about") {
        const bool allowed =
            entry.is_scalar() &&
            (entry.text == "z" || (!is_planar_ && (entry.text == "x" || entry.text == "y")));
        if (!allowed) {
          fail(entry.mark, "about: found '" + printable(entry.text, 80) + "', allowed is " +
                               (is_planar_ ? "z" : "x, y or z") +
                               ", the axis through the origin that repetitions turn about");
        }
        repetition.axis = entry.text[0];
      } else {
        repetition.what.keys.push_back(key);
        repetition.what.children.push_back(entry);
      }
    }
    return repetition;
  }

  template <class Action>
  void repeat(const Repetition& repetition, const Action& action) {
    counts_.push_back(0);
    for (int i = 1; i <= repetition.n; ++i) {
      counts_.back() = i;
      action();
    }
    counts_.pop_back();
  }

  void turn(YamlTree& part, const Repetition& repetition) const {
    if (repetition.axis == 0 || counts_.back() == 1) return;
    turn_all(part, repetition.axis, turn_of_part(counts_.back() - 1, repetition.n));
  }

  const std::string& file_;
  bool is_planar_ = false, has_any_ = false;
  std::size_t n_values_ = 0;
  std::map<std::string, Variable> variables_;
  std::vector<int> counts_;  ///< of the repetitions around a value, the innermost last
};

/// Whether a text may have any, so that others need not be gone through again.
bool may_have_any(const std::string& text) {
  return text.find('=') != std::string::npos || text.find("variables") != std::string::npos ||
         text.find("repeat") != std::string::npos || text.find("angle_deg") != std::string::npos;
}

}  // namespace

std::optional<WrittenOut> write_out(const std::string& text, const std::string& source_name) {
  if (!may_have_any(text)) return std::nullopt;
  Shorthand shorthand(source_name);
  const YamlTree tree = shorthand.written_out(read_tree(text));
  if (!shorthand.has_any()) return std::nullopt;
  WrittenOut result;
  result.text = text_of(tree, result.marks);
  return result;
}

}  // namespace stillframe
