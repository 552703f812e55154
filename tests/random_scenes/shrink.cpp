#include "tests/random_scenes/shrink.hpp"

#include <yaml-cpp/yaml.h>

#include <chrono>
#include <vector>

namespace stillframe::random_scenes {

namespace {

bool mentions(const YAML::Node& node, const std::string& name) {
  if (node.IsScalar()) return node.Scalar() == name;
  for (const auto& child : node) {
    if (mentions(node.IsMap() ? child.second : YAML::Node(child), name)) return true;
  }
  return false;
}

/// A copy without what names something; lists of names get shorter.
YAML::Node without_name(const YAML::Node& node, const std::string& name, int depth = 0) {
  if (node.IsScalar()) return YAML::Clone(node);
  YAML::Node copy(node.Type());
  copy.SetStyle(node.Style());
  for (const auto& child : node) {
    if (node.IsMap()) {
      if (child.first.Scalar() == name) continue;
      // An entry of nodes or elements goes as a whole.
      if (depth == 1 && child.second.IsMap() && mentions(child.second, name)) continue;
      copy[child.first.Scalar()] = without_name(child.second, name, depth + 1);
    } else {
      const YAML::Node item(child);
      if (item.IsScalar() ? item.Scalar() == name : false) continue;
      if (item.IsMap() && mentions(item, name)) {
        const bool listed = item["nodes"] && item["nodes"].size() > 1;
        if (!listed) continue;
      }
      copy.push_back(without_name(item, name, depth + 1));
    }
  }
  return copy;
}

/// A copy without the entry at a path of positions.
YAML::Node without_entry(const YAML::Node& node, const std::vector<size_t>& path,
                         size_t level = 0) {
  if (node.IsScalar()) return YAML::Clone(node);
  YAML::Node copy(node.Type());
  copy.SetStyle(node.Style());
  size_t i = 0;
  for (const auto& child : node) {
    const bool here = level < path.size() && i++ == path[level], last = level + 1 == path.size();
    if (here && last) continue;
    const auto of = [&](const YAML::Node& item) {
      return here ? without_entry(item, path, level + 1) : YAML::Clone(item);
    };
    if (node.IsMap()) {
      copy[child.first.Scalar()] = of(child.second);
    } else {
      copy.push_back(of(YAML::Node(child)));
    }
  }
  return copy;
}

void add_paths(const YAML::Node& node, size_t depth, std::vector<size_t> path,
               std::vector<std::vector<size_t>>& paths) {
  if (node.IsScalar() || node.IsNull()) return;
  size_t i = 0;
  for (const auto& child : node) {
    path.push_back(i++);
    if (path.size() == depth) {
      paths.push_back(path);
    } else {
      add_paths(node.IsMap() ? child.second : YAML::Node(child), depth, path, paths);
    }
    path.pop_back();
  }
}

/// All scenes with one thing less, the largest things first.
std::vector<std::function<YAML::Node()>> smaller(const YAML::Node& scene) {
  std::vector<std::function<YAML::Node()>> all;
  for (const char* block : {"elements", "nodes"}) {
    for (const auto& item : scene[block]) {
      const std::string name = item.first.Scalar();
      all.push_back([scene, name] { return without_name(scene, name); });
    }
  }
  std::vector<std::vector<size_t>> paths;
  for (const size_t depth : {1, 2, 3}) add_paths(scene, depth, {}, paths);
  for (const auto& path : paths) {
    all.push_back([scene, path] { return without_entry(scene, path); });
  }
  return all;
}

std::string text_of(const YAML::Node& scene) {
  YAML::Emitter out;
  out << scene;
  return std::string(out.c_str()) + "\n";
}

}  // namespace

std::string shrink(std::string text, const std::function<bool(const std::string&)>& fails,
                   double longest_s) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(longest_s);
  for (bool shrunk = true; shrunk && Clock::now() < end;) {
    shrunk = false;
    for (const auto& candidate : smaller(YAML::Load(text))) {
      if (Clock::now() > end) break;
      const std::string trial = text_of(candidate());
      if (trial.size() >= text.size() || !fails(trial)) continue;
      text = trial;
      shrunk = true;
      break;
    }
  }
  return text;
}

}  // namespace stillframe::random_scenes
