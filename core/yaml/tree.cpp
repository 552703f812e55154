#include "core/yaml/tree.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <sstream>
#include <utility>

#include "core/yaml/quoted.hpp"

namespace stillframe {

namespace {

class TreeBuilder : public YAML::EventHandler {
 public:
  YamlTree take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { add({.mark = mark}); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                const std::string& text) override {
    add({.mark = mark, .kind = YamlTree::Kind::scalar, .text = text});
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    open_.push_back({.mark = mark, .kind = YamlTree::Kind::sequence});
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {
    open_.push_back({.mark = mark, .kind = YamlTree::Kind::map});
  }
  void OnMapEnd() override { close(); }

 private:
  void close() {
    YamlTree done = std::move(open_.back());
    open_.pop_back();
    add(std::move(done));
  }
  void add(YamlTree value) {
    if (open_.empty()) {
      root_ = std::move(value);
      return;
    }
    YamlTree& in = open_.back();
    const bool is_key = in.is_map() && in.keys.size() == in.children.size();
    (is_key ? in.keys : in.children).push_back(std::move(value));
  }

  YamlTree root_;
  std::vector<YamlTree> open_;
};

/// Everything in flow style: its indentation says nothing.
class TreeWriter {
 public:
  explicit TreeWriter(std::vector<YAML::Mark>& marks) : marks_(marks) { marks_.clear(); }

  void write(const YamlTree& tree) {
    if (tree.is_scalar()) {
      line(tree.mark, quoted(tree.text));
      return;
    }
    if (tree.kind == YamlTree::Kind::null) {
      line(tree.mark, "~");
      return;
    }
    line(tree.mark, tree.is_map() ? "{" : "[");
    for (std::size_t i = 0; i < tree.children.size(); ++i) {
      if (tree.is_map()) line(tree.keys[i].mark, quoted(tree.keys[i].text) + ":");
      write(tree.children[i]);
      text_.back() = ',';
      text_ += '\n';
    }
    line(tree.mark, tree.is_map() ? "}" : "]");
  }

  std::string text() { return std::move(text_); }

 private:
  void line(const YAML::Mark& mark, const std::string& text) {
    text_ += text + "\n";
    marks_.push_back(mark);
  }

  std::vector<YAML::Mark>& marks_;
  std::string text_;
};

}  // namespace

const YamlTree* YamlTree::find(const std::string& key) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].text == key) return &children[i];
  }
  return nullptr;
}

YamlTree read_tree(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  TreeBuilder builder;
  parser.HandleNextDocument(builder);
  return builder.take();
}

std::string text_of(const YamlTree& tree, std::vector<YAML::Mark>& marks) {
  TreeWriter writer(marks);
  writer.write(tree);
  return writer.text();
}

}  // namespace stillframe
