#include "core/yaml/reader.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include "core/files/bytes_of_file.hpp"
#include "core/files/utf8.hpp"
#include "core/yaml/load.hpp"
#include "core/yaml/shorthand.hpp"
#include "core/yaml/to_number.hpp"

namespace stillframe {

struct YamlReader::Source {
  std::string name, text;
  std::filesystem::path folder;
  std::vector<YAML::Mark> marks = {};  ///< of each line, where it is not the text that was parsed

  YAML::Mark written_at(const YAML::Mark& mark) const {
    if (marks.empty() || mark.is_null()) return mark;
    return marks[static_cast<std::size_t>(mark.line)];
  }
};

namespace {

/// Of a value that is not allowed a message shows so many bytes, and of everything together so
/// many.
constexpr std::size_t longest_shown = 80, longest_message = 2000;

std::string shape_of(const YAML::Node& node) {
  if (node.IsMap()) return "a map";
  if (node.IsSequence()) return "a sequence of " + std::to_string(node.size());
  if (node.IsNull()) return "nothing";
  return "'" + printable(node.Scalar(), longest_shown) + "'";
}

template <class Words>
std::string join(const Words& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : ", ") + std::string(word);
  return text;
}

}  // namespace

std::string shortest_digits(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

YamlReader::YamlReader(std::shared_ptr<const Source> source, const YAML::Node& node,
                       std::string name)
    : source_(std::move(source)),
      node_(std::make_shared<const YAML::Node>(node)),
      name_(std::move(name)) {}

YamlReader YamlReader::from_file(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw InputError(path.string() + ": is a folder, a YAML file is needed");
  }
  const auto text = bytes_of_file(path, most_yaml_bytes);
  if (!text || text->empty()) {
    throw InputError(path.string() + ": cannot be read: " + why_no_bytes(path));
  }
  const auto folder = path.parent_path();
  return from_text(*text, path.string(), folder.empty() ? std::filesystem::path(".") : folder);
}

YamlReader YamlReader::from_text(const std::string& text, const std::string& source_name,
                                 const std::filesystem::path& folder) {
  Source source{source_name, text, folder};
  YAML::Node node = load_yaml(text, source_name);
  if (auto written = write_out(text, source_name)) {
    node = YAML::Load(written->text);
    source.marks = std::move(written->marks);
  }
  return YamlReader(std::make_shared<const Source>(std::move(source)), node, "");
}

YamlReader YamlReader::as_written() const {
  return YamlReader(
      std::make_shared<const Source>(Source{source_->name, source_->text, source_->folder}),
      YAML::Load(source_->text), "");
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

void YamlReader::allow_only(const std::vector<std::string_view>& keys) const {
  if (!node_->IsMap()) fail_found("a map with the keys " + join(keys));
  for (const auto& entry : *node_) {
    const std::string& key = entry.first.Scalar();
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    const std::string near = nearest_name(key, {keys.begin(), keys.end()});
    throw InputError(place_of(source_->name, source_->written_at(entry.first.Mark())) + ": " +
                     printable((name_.empty() ? "" : name_ + ".") + key, longest_message) +
                     ": unknown key" + (near.empty() ? "" : " (did you mean '" + near + "'?)") +
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

double YamlReader::number(double largest) const {
  const auto value = node_->IsScalar() ? to_number(node_->Scalar()) : std::nullopt;
  if (!value) fail_found("a finite number without a unit (SI units are understood)");
  if (std::abs(*value) > largest) {
    fail_found("a number from -" + shortest_digits(largest) + " to " + shortest_digits(largest));
  }
  return *value;
}

double YamlReader::positive() const {
  const double value = number();
  if (!(value > 0)) fail_found("a number above 0");
  if (value < smallest_number)
    fail_found("a number from " + shortest_digits(smallest_number) + " up");
  return value;
}

double YamlReader::non_negative() const {
  const double value = number();
  if (!(value >= 0)) fail_found("a number that is not negative");
  if (value > 0 && value < smallest_number) {
    fail_found("0 or a number from " + shortest_digits(smallest_number) + " up");
  }
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

Eigen::VectorXd YamlReader::vector(Eigen::Index size, double largest) const {
  const std::string allowed =
      size < 0 ? "a sequence of numbers" : "a sequence of " + std::to_string(size) + " numbers";
  if (!node_->IsSequence()) fail_found(allowed);
  const auto values = items();
  if (size >= 0 && static_cast<Eigen::Index>(values.size()) != size) fail_found(allowed);
  Eigen::VectorXd result(static_cast<Eigen::Index>(values.size()));
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    result(i) = values[static_cast<size_t>(i)].number(largest);
  }
  return result;
}

Eigen::MatrixXd YamlReader::matrix(Eigen::Index rows, Eigen::Index cols, double largest) const {
  const std::string allowed =
      std::to_string(rows) + " rows of " + std::to_string(cols) + " numbers";
  if (!node_->IsSequence()) fail_found(allowed);
  const auto lines = items();
  if (static_cast<Eigen::Index>(lines.size()) != rows) fail_found(allowed);
  Eigen::MatrixXd result(rows, cols);
  for (Eigen::Index i = 0; i < rows; ++i) {
    result.row(i) = lines[static_cast<size_t>(i)].vector(cols, largest).transpose();
  }
  return result;
}

std::pair<std::filesystem::path, std::string> YamlReader::file_bytes(std::size_t most) const {
  const std::filesystem::path path = folder() / text();
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) fail("'" + path.string() + "' is a folder");
  auto bytes = bytes_of_file(path, most);
  if (!bytes || bytes->empty()) {
    fail("the file '" + path.string() + "' cannot be read: " + why_no_bytes(path));
  }
  if (bytes->size() > most) {
    fail("the file '" + path.string() + "' has more than " + std::to_string(most >> 20) + " MiB");
  }
  return {path, *std::move(bytes)};
}

void YamlReader::fail(const std::string& message) const {
  throw InputError(place() + ": " +
                   printable((name_.empty() ? "" : name_ + ": ") + message, longest_message));
}

void YamlReader::fail_found(const std::string& allowed) const {
  fail("found " + shape_of(*node_) + ", allowed is " + allowed);
}

std::string YamlReader::place() const {
  return place_of(source_->name, source_->written_at(node_->Mark()));
}

std::string YamlReader::dump() const { return YAML::Dump(*node_) + "\n"; }

std::filesystem::path YamlReader::folder() const { return source_->folder; }

const std::string& YamlReader::source_text() const { return source_->text; }

std::string YamlReader::source_text_with(const std::string& text) const {
  std::string all = source_->text;
  if (!node_->IsScalar() || node_->Mark().is_null()) return all;
  const std::string byte_order_mark = "\xEF\xBB\xBF";  // which a place does not count
  const auto at = static_cast<std::size_t>(source_->written_at(node_->Mark()).pos) +
                  (all.starts_with(byte_order_mark) ? byte_order_mark.size() : 0);
  const std::string& own = node_->Scalar();
  if (at > all.size()) return all;
  for (const std::string quote : {"", "'", "\""}) {
    const std::string written = quote + own + quote;
    if (all.compare(at, written.size(), written) != 0) continue;
    YAML::Emitter quoted;
    quoted << YAML::DoubleQuoted << text;
    return all.replace(at, written.size(), quoted.c_str());
  }
  return all;
}

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
