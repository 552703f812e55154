#include "tools/sweep_grid.hpp"

#include <cmath>
#include <optional>
#include <set>

#include "core/errors/input_error.hpp"
#include "core/yaml/to_number.hpp"

namespace stillframe::tools {

namespace {

constexpr std::size_t most_points = 1'000'000;

std::vector<std::string> split(const std::string& text, char between) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end = text.find(between); end != std::string::npos;
       end = text.find(between, begin)) {
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  parts.push_back(text.substr(begin));
  return parts;
}

double number(const std::string& text, const std::string& whole) {
  const std::optional<double> value = to_number(text);
  if (!value) throw InputError("--set: " + whole + ": found '" + text + "', allowed is a number");
  return *value;
}

std::vector<std::string> range(const std::vector<std::string>& parts, const std::string& whole) {
  const bool logarithmic = parts.size() == 4;
  if (parts.size() < 3 || parts.size() > 4 || (logarithmic && parts[3] != "log")) {
    throw InputError("--set: " + whole + ": allowed is FROM:TO:COUNT or FROM:TO:COUNT:log");
  }
  const double from = number(parts[0], whole), to = number(parts[1], whole),
               count = number(parts[2], whole);
  if (!(count >= 2) || count != std::floor(count) || count > static_cast<double>(most_points)) {
    throw InputError("--set: " + whole + ": found '" + parts[2] +
                     "' values, allowed is a whole number from 2 up");
  }
  if (logarithmic && !(from > 0 && to > 0)) {
    throw InputError("--set: " + whole + ": equal factors need two numbers above 0");
  }
  std::vector<std::string> values;
  for (double i = 0; i < count; ++i) {
    const double part = i / (count - 1);
    const double value = i == 0           ? from
                         : i == count - 1 ? to
                         : logarithmic    ? from * std::pow(to / from, part)
                                          : from + (to - from) * part;
    values.push_back(shortest_digits(value));
  }
  return values;
}

/// Whether a name is what a pattern with * says.
bool matches(const std::string& pattern, const std::string& name) {
  const std::size_t star = pattern.find('*');
  if (star == std::string::npos) return pattern == name;
  if (name.compare(0, star, pattern, 0, star) != 0) return false;
  const std::string rest = pattern.substr(star + 1);
  for (std::size_t i = star; i <= name.size(); ++i) {
    if (matches(rest, name.substr(i))) return true;
  }
  return false;
}

/// What an item of a list is called: by its number, name or node.
bool is_called(const YamlReader& item, std::size_t number, const std::string& pattern) {
  if (matches(pattern, std::to_string(number))) return true;
  if (!item.is_map()) return false;
  for (const char* key : {"name", "node"}) {
    if (const auto value = item.find(key); value && value->is_scalar()) {
      if (matches(pattern, value->text())) return true;
    }
  }
  return false;
}

void find_all(const YamlReader& at, const std::vector<std::string>& path, std::size_t depth,
              std::vector<YamlReader>& found) {
  if (depth == path.size()) {
    if (at.is_scalar()) found.push_back(at);
    return;
  }
  if (at.is_map()) {
    for (const auto& [key, value] : at.entries()) {
      if (matches(path[depth], key)) find_all(value, path, depth + 1, found);
    }
  } else if (at.is_sequence()) {
    const auto items = at.items();
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (is_called(items[i], i + 1, path[depth])) find_all(items[i], path, depth + 1, found);
    }
  }
}

std::vector<YamlReader> places(const YamlReader& block, const std::vector<std::string>& path,
                               std::size_t first) {
  std::vector<YamlReader> found;
  find_all(block, path, first, found);
  return found;
}

std::string file_of(const YamlReader& block) {
  const std::string place = block.place();
  return place.substr(0, place.rfind(':', place.rfind(':') - 1));
}

}  // namespace

SweptKey parse_swept_key(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
    throw InputError("--set: found '" + text +
                     "', allowed is PATH=VALUE,VALUE,... or PATH=FROM:TO:COUNT");
  }
  SweptKey key{text.substr(0, equals), {}};
  const std::string values = text.substr(equals + 1);
  const auto ends = split(values, ':');
  key.values = ends.size() > 1 ? range(ends, text) : split(values, ',');
  for (const std::string& value : key.values) {
    if (value.empty()) throw InputError("--set: " + text + ": a value is empty");
  }
  return key;
}

SweepGrid::SweepGrid(std::vector<SweptKey> keys) : keys_(std::move(keys)) {
  std::set<std::string> known;
  for (const SweptKey& key : keys_) {
    if (!known.insert(key.path).second) {
      throw InputError("--set: " + key.path + " is given twice");
    }
    if (key.values.size() > most_points / size_) {
      throw InputError("--set: more than a million points; take fewer values");
    }
    size_ *= key.values.size();
  }
}

std::vector<std::string> SweepGrid::values(std::size_t i) const {
  std::vector<std::string> values(keys_.size());
  for (std::size_t k = keys_.size(); k-- > 0;) {
    values[k] = keys_[k].values[i % keys_[k].values.size()];
    i /= keys_[k].values.size();
  }
  return values;
}

SceneBlocks with_values(SceneBlocks blocks, const std::vector<SweptKey>& keys,
                        const std::vector<std::string>& values) {
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const std::vector<std::string> path = split(keys[k].path, '.');
    const bool elsewhere = blocks.controller && path.front() == "controller";
    YamlReader& block = elsewhere ? *blocks.controller : blocks.scene;
    const std::size_t first = elsewhere ? 1 : 0;
    const std::string file = elsewhere ? file_of(block) : blocks.file;
    const std::size_t n = places(block.as_written(), path, first).size();
    if (n == 0) {
      throw InputError("--set: " + keys[k].path + ": " + file +
                       " has no such value; allowed is a number or word that is written there "
                       "(write the default where a key is left out)");
    }
    for (std::size_t i = 0; i < n; ++i) {
      const YamlReader at = places(block.as_written(), path, first)[i];
      if (at.text() == values[k]) continue;
      const std::string text = at.source_text_with(values[k]);
      if (text == block.source_text()) {
        at.fail("is not written as plain text, and cannot be swept");
      }
      block = YamlReader::from_text(text, file, block.folder());
    }
  }
  return blocks;
}

}  // namespace stillframe::tools
