#include "core/yaml/reader.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numeric>
#include <set>
#include <sstream>

namespace stillframe {

struct YamlReader::Source {
  std::string name, text;
  std::filesystem::path folder;
};

namespace {

std::string place_of(const std::string& file, const YAML::Mark& mark) {
  if (mark.is_null()) return file;
  return file + ":" + std::to_string(mark.line + 1) + ":" + std::to_string(mark.column + 1);
}

std::string shape_of(const YAML::Node& node) {
  if (node.IsMap()) return "a map";
  if (node.IsSequence()) return "a sequence of " + std::to_string(node.size());
  if (node.IsNull()) return "nothing";
  return "'" + node.Scalar() + "'";
}

/// yaml-cpp keeps the last of two equal keys without a word; a person would never know which one
/// counts.
void refuse_duplicate_keys(const std::string& file, const YAML::Node& node) {
  if (node.IsMap()) {
    std::set<std::string> seen;
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) {
        throw InputError(place_of(file, entry.first.Mark()) + ": a key must be a plain word");
      }
      if (!seen.insert(entry.first.Scalar()).second) {
        throw InputError(place_of(file, entry.first.Mark()) + ": " + entry.first.Scalar() +
                         ": this key stands twice in the same map");
      }
    }
  }
  if (node.IsMap() || node.IsSequence()) {
    for (const auto& entry : node) refuse_duplicate_keys(file, node.IsMap() ? entry.second : entry);
  }
}

/// The place of the first tab in the indentation of a text, which YAML does not allow and yaml-cpp
/// takes for all kinds of things; empty if there is none.
std::string tab_in_indentation(const std::string& file, const std::string& text) {
  int line = 1;
  for (size_t start = 0; start < text.size(); ++line) {
    const size_t stop = text.find_first_not_of(" \t", start);
    const size_t tab = text.substr(start, std::min(stop, text.size()) - start).find('\t');
    if (tab != std::string::npos) {
      return file + ":" + std::to_string(line) + ":" + std::to_string(tab + 1);
    }
    const size_t end = text.find('\n', start);
    start = end == std::string::npos ? text.size() : end + 1;
  }
  return "";
}

/// How many bytes the UTF-8 sequence at the beginning has, 0 if there is none. Source: RFC 3629,
/// section 4.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  for (std::size_t i = 1; i < length; ++i) {
    if (byte(i) < 0x80 || byte(i) > 0xBF) return 0;
  }
  // Longer than it need be, a half of a pair of UTF-16, or beyond U+10FFFF.
  const bool impossible = (first == 0xE0 && byte(1) < 0xA0) || (first == 0xED && byte(1) > 0x9F) ||
                          (first == 0xF0 && byte(1) < 0x90) || (first == 0xF4 && byte(1) > 0x8F);
  return impossible ? 0 : length;
}

/// Names go into JSON, pages and messages, all of which are UTF-8.
void refuse_other_encodings(const std::string& file, std::string_view text) {
  int line = 1, column = 1;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0) {
      char hex[8];
      std::snprintf(hex, sizeof hex, "0x%02x", static_cast<unsigned char>(text.front()));
      throw InputError(file + ":" + std::to_string(line) + ":" + std::to_string(column) +
                       ": found the byte " + hex + ", allowed is text in UTF-8");
    }
    column = text.front() == '\n' ? 1 : column + 1;
    line += text.front() == '\n';
    text.remove_prefix(length);
  }
}

std::string join(std::initializer_list<std::string_view> words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : ", ") + std::string(word);
  return text;
}

std::optional<double> to_number(const std::string& text) {
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* end = text.data() + text.size();
  double value = 0;
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

YamlReader::YamlReader(std::shared_ptr<const Source> source, const YAML::Node& node,
                       std::string name)
    : source_(std::move(source)),
      node_(std::make_shared<const YAML::Node>(node)),
      name_(std::move(name)) {}

YamlReader YamlReader::from_file(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::stringstream text;
  if (std::filesystem::is_directory(path)) {
    throw InputError(path.string() + ": is a folder, a YAML file is needed");
  }
  if (!file || !(text << file.rdbuf())) {
    throw InputError(path.string() + ": cannot be read (missing, empty or not allowed)");
  }
  const auto folder = path.parent_path();
  return from_text(text.str(), path.string(), folder.empty() ? std::filesystem::path(".") : folder);
}

YamlReader YamlReader::from_text(const std::string& text, const std::string& source_name,
                                 const std::filesystem::path& folder) {
  refuse_other_encodings(source_name, text);
  YAML::Node node;
  try {
    node = YAML::Load(text);
  } catch (const YAML::ParserException& error) {
    const std::string tab = tab_in_indentation(source_name, text);
    if (!tab.empty()) {
      throw InputError(tab + ": not YAML: a tab in the indentation, allowed are spaces only");
    }
    throw InputError(place_of(source_name, error.mark) + ": not YAML: " + error.msg);
  }
  refuse_duplicate_keys(source_name, node);
  return YamlReader(std::make_shared<const Source>(Source{source_name, text, folder}), node, "");
}

std::optional<YamlReader> YamlReader::find(const std::string& key) const {
  if (!node_->IsMap()) fail_found("a map");
  for (const auto& entry : *node_) {
    if (entry.first.Scalar() == key) {
      return YamlReader(source_, entry.second, name_.empty() ? key : name_ + "." + key);
    }
  }
  return std::nullopt;
}

YamlReader YamlReader::require(const std::string& key) const {
  auto value = find(key);
  if (!value) fail("the key '" + key + "' is missing");
  return *value;
}

void YamlReader::allow_only(std::initializer_list<std::string_view> keys) const {
  if (!node_->IsMap()) fail_found("a map with the keys " + join(keys));
  for (const auto& entry : *node_) {
    const std::string& key = entry.first.Scalar();
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    const std::string near = nearest_name(key, {keys.begin(), keys.end()});
    throw InputError(place_of(source_->name, entry.first.Mark()) + ": " +
                     (name_.empty() ? "" : name_ + ".") + key + ": unknown key" +
                     (near.empty() ? "" : " (did you mean '" + near + "'?)") +
                     "; allowed: " + join(keys));
  }
}

bool YamlReader::is_map() const { return node_->IsMap(); }
bool YamlReader::is_sequence() const { return node_->IsSequence(); }
bool YamlReader::is_scalar() const { return node_->IsScalar(); }

std::vector<std::pair<std::string, YamlReader>> YamlReader::entries() const {
  if (!node_->IsMap()) fail_found("a map");
  std::vector<std::pair<std::string, YamlReader>> result;
  for (const auto& entry : *node_) {
    const std::string& key = entry.first.Scalar();
    result.emplace_back(key,
                        YamlReader(source_, entry.second, name_.empty() ? key : name_ + "." + key));
  }
  return result;
}

std::vector<YamlReader> YamlReader::items() const {
  if (!node_->IsSequence()) fail_found("a sequence, as in [a, b]");
  std::vector<YamlReader> result;
  for (const auto& item : *node_) {
    result.push_back(
        YamlReader(source_, item, name_ + "[" + std::to_string(result.size() + 1) + "]"));
  }
  return result;
}

double YamlReader::number() const {
  if (node_->IsScalar()) {
    if (const auto value = to_number(node_->Scalar())) return *value;
  }
  fail_found("a finite number without a unit (SI units are understood)");
}

double YamlReader::positive() const {
  const double value = number();
  if (!(value > 0)) fail_found("a number above 0");
  return value;
}

double YamlReader::non_negative() const {
  const double value = number();
  if (!(value >= 0)) fail_found("a number that is not negative");
  return value;
}

std::int64_t YamlReader::integer(std::int64_t lowest) const {
  const std::string allowed = "a whole number from " + std::to_string(lowest) + " up";
  if (!node_->IsScalar()) fail_found(allowed);
  const std::string& text = node_->Scalar();
  std::int64_t value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size() || value < lowest) {
    fail_found(allowed);
  }
  return value;
}

bool YamlReader::boolean() const {
  if (node_->IsScalar() && node_->Scalar() == "true") return true;
  if (node_->IsScalar() && node_->Scalar() == "false") return false;
  fail_found("true or false");
}

std::string YamlReader::text() const {
  if (!node_->IsScalar() || node_->Scalar().empty()) fail_found("a word");
  return node_->Scalar();
}

std::string YamlReader::one_of(std::initializer_list<std::string_view> words) const {
  const std::string word = node_->IsScalar() ? node_->Scalar() : "";
  if (std::find(words.begin(), words.end(), word) != words.end()) return word;
  fail_found("one of " + join(words));
}

Eigen::VectorXd YamlReader::vector(Eigen::Index size) const {
  const std::string allowed =
      size < 0 ? "a sequence of numbers" : "a sequence of " + std::to_string(size) + " numbers";
  if (!node_->IsSequence()) fail_found(allowed);
  const auto values = items();
  if (size >= 0 && static_cast<Eigen::Index>(values.size()) != size) fail_found(allowed);
  Eigen::VectorXd result(static_cast<Eigen::Index>(values.size()));
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    result(i) = values[static_cast<size_t>(i)].number();
  }
  return result;
}

Eigen::MatrixXd YamlReader::matrix(Eigen::Index rows, Eigen::Index cols) const {
  const std::string allowed =
      std::to_string(rows) + " rows of " + std::to_string(cols) + " numbers";
  if (!node_->IsSequence()) fail_found(allowed);
  const auto lines = items();
  if (static_cast<Eigen::Index>(lines.size()) != rows) fail_found(allowed);
  Eigen::MatrixXd result(rows, cols);
  for (Eigen::Index i = 0; i < rows; ++i) {
    result.row(i) = lines[static_cast<size_t>(i)].vector(cols).transpose();
  }
  return result;
}

void YamlReader::fail(const std::string& message) const {
  throw InputError(place() + ": " + (name_.empty() ? "" : name_ + ": ") + message);
}

void YamlReader::fail_found(const std::string& allowed) const {
  fail("found " + shape_of(*node_) + ", allowed is " + allowed);
}

std::string YamlReader::place() const { return place_of(source_->name, node_->Mark()); }

std::string YamlReader::dump() const { return YAML::Dump(*node_) + "\n"; }

std::filesystem::path YamlReader::folder() const { return source_->folder; }

const std::string& YamlReader::source_text() const { return source_->text; }

std::string nearest_name(const std::string& word, const std::vector<std::string>& candidates) {
  std::string best;
  size_t best_distance = word.size() / 2 + 1;
  for (const auto& candidate : candidates) {
    std::vector<size_t> row(candidate.size() + 1);
    std::iota(row.begin(), row.end(), size_t{0});
    for (size_t i = 0; i < word.size(); ++i) {
      size_t diagonal = row[0];
      row[0] = i + 1;
      for (size_t j = 0; j < candidate.size(); ++j) {
        const size_t substitute = diagonal + (word[i] == candidate[j] ? 0 : 1);
        diagonal = row[j + 1];
        row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, substitute});
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return best;
}

}  // namespace stillframe
