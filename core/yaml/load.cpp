#include "core/yaml/load.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cstdio>
#include <set>
#include <sstream>
#include <vector>

#include "core/yaml/input_error.hpp"

namespace stillframe {

namespace {

std::string hex(unsigned char byte) {
  char digits[8];
  std::snprintf(digits, sizeof digits, "%02x", static_cast<unsigned>(byte));
  return digits;
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

/// Those that a terminal obeys rather than shows: C0, delete, and C1 (two bytes in UTF-8).
bool is_control(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  if (first < 0x20 || first == 0x7F) return true;
  return first == 0xC2 && text.size() > 1 && static_cast<unsigned char>(text[1]) < 0xA0;
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
                       ": found the byte 0x" + hex(static_cast<unsigned char>(first)) +
                       ", allowed is " + (length == 0 ? "text in UTF-8" : "printable text"));
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

std::string printable(std::string_view text, std::size_t longest) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = std::max<std::size_t>(utf8_length(text), 1);
    if (out.size() + length > longest) return out + "...";
    if (utf8_length(text) == 0 || is_control(text)) {
      for (std::size_t i = 0; i < length; ++i) {
        out += "\\x" + hex(static_cast<unsigned char>(text[i]));
      }
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(length);
  }
  return out;
}

}  // namespace stillframe
