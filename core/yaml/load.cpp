#include "core/yaml/load.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <set>
#include <sstream>
#include <vector>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/files/utf8.hpp"

namespace stillframe {

namespace {

std::string hex(char byte) {
  return formatted("0x%02x", static_cast<unsigned>(static_cast<unsigned char>(byte)));
}

/// The place of the first tab in the indentation of a text, which YAML does not allow and yaml-cpp
/// takes for all kinds of things; empty if there is none.
std::string tab_in_indentation(const std::string& file, const std::string& text) {
  int line = 1;
  for (size_t start = 0; start < text.size(); ++line) {
    const size_t stop = std::min(text.find_first_not_of(" \t", start), text.size());
    const size_t tab = std::string_view(text).substr(start, stop - start).find('\t');
    if (tab != std::string::npos) {
      return file + ":" + std::to_string(line) + ":" + std::to_string(tab + 1);
    }
    const size_t end = text.find('\n', start);
    start = end == std::string::npos ? text.size() : end + 1;
  }
  return "";
}

/// Names go into JSON, pages, messages and terminals, all of which are UTF-8.
void refuse_other_bytes(const std::string& file, std::string_view text) {
  int line = 1, column = 1;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const char first = text.front();
    const bool allowed = first == '\n' || first == '\r' || first == '\t' || !is_control(text);
    if (length == 0 || !allowed) {
      throw InputError(file + ":" + std::to_string(line) + ":" + std::to_string(column) +
                       ": found the byte " + hex(first) + ", allowed is " +
                       (length == 0 ? "text in UTF-8" : "printable text"));
    }
    column = first == '\n' ? 1 : column + 1;
    line += first == '\n';
    text.remove_prefix(length);
  }
}

/// Goes through a text as yaml-cpp reads it, keeps the keys of the maps that are open and nothing
/// else, and throws at the first thing that is not allowed.
class Guard : public YAML::EventHandler {
 public:
  explicit Guard(const std::string& file) : file_(file) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++n_documents_ > 1) fail(mark, "found a second document (---), allowed is one");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    value(mark, "", anchor, nullptr);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { refuse_aliases(mark); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    value(mark, tag, anchor, &text);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    value(mark, tag, anchor, nullptr);
    open(mark, false);
  }
  void OnSequenceEnd() override { open_.pop_back(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    value(mark, tag, anchor, nullptr);
    open(mark, true);
  }
  void OnMapEnd() override { open_.pop_back(); }

 private:
  struct Open {
    bool is_map = false, at_key = false;
    std::string key = {};
    std::set<std::string> keys = {};
  };

  /// Every key and every value, maps and sequences included; text: of a scalar.
  void value(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
             const std::string* text) {
    if (anchor != 0) refuse_aliases(mark);
    // What yaml-cpp calls plain and quoted scalars.
    if (!tag.empty() && tag != "?" && tag != "!") {
      fail(mark, "found the tag " + printable(tag, 40) + ", allowed are values without a tag");
    }
    if (++n_values_ > most_yaml_values) {
      fail(mark, "found more than " + std::to_string(most_yaml_values) + " values");
    }
    if (open_.empty() || !open_.back().is_map) return;
    Open& map = open_.back();
    if (map.at_key) take_key(mark, text, map);
    map.at_key = !map.at_key;
  }

  void take_key(const YAML::Mark& mark, const std::string* text, Open& map) {
    map.key.clear();
    if (text == nullptr) fail(mark, "a key must be a plain word");
    if (text->size() > longest_yaml_key) {
      fail(mark, "found a key of " + std::to_string(text->size()) + " bytes, allowed are " +
                     std::to_string(longest_yaml_key));
    }
    map.key = *text;
    // yaml-cpp keeps the last of two equal keys without a word; a person would never know which one
    // counts.
    if (!map.keys.insert(*text).second) fail(mark, "this key stands twice in the same map");
  }

  void open(const YAML::Mark& mark, bool is_map) {
    if (open_.size() == most_yaml_depth) {
      fail(mark, "found more than " + std::to_string(most_yaml_depth) +
                     " maps and sequences inside each other");
    }
    open_.push_back({.is_map = is_map, .at_key = is_map});
  }

  [[noreturn]] void refuse_aliases(const YAML::Mark& mark) const {
    fail(mark, "found an anchor or alias (& or *), allowed are values written out");
  }

  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& message) const {
    std::string name;
    for (const Open& level : open_) {
      if (level.key.empty()) continue;
      name += (name.empty() ? "" : ".") + printable(level.key, 60);
    }
    throw InputError(place_of(file_, mark) + ": " + (name.empty() ? "" : name + ": ") + message);
  }

  const std::string& file_;
  std::vector<Open> open_;
  std::size_t n_values_ = 0;
  int n_documents_ = 0;
};

}  // namespace

std::string place_of(const std::string& file, const YAML::Mark& mark) {
  if (mark.is_null()) return file;
  return file + ":" + std::to_string(mark.line + 1) + ":" + std::to_string(mark.column + 1);
}

YAML::Node load_yaml(const std::string& text, const std::string& source_name) {
  if (text.size() > most_yaml_bytes) {
    throw InputError(source_name + ": found " + std::to_string(text.size()) +
                     " bytes, allowed are " + std::to_string(most_yaml_bytes));
  }
  refuse_other_bytes(source_name, text);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    Guard guard(source_name);
    while (parser.HandleNextDocument(guard)) {
    }
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    const std::string tab = tab_in_indentation(source_name, text);
    if (!tab.empty()) {
      throw InputError(tab + ": not YAML: a tab in the indentation, allowed are spaces only");
    }
    throw InputError(place_of(source_name, error.mark) +
                     ": not YAML: " + printable(error.msg, 200));
  }
}

}  // namespace stillframe
