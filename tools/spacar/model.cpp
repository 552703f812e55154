#include "tools/spacar/model.hpp"

#include <algorithm>
#include <stdexcept>

namespace stillframe::tools::spacar {

std::string lines_of(const std::set<int>& lines) {
  std::string text = lines.size() == 1 ? "line " : "lines ";
  std::size_t i = 0;
  for (const int line : lines) {
    if (i > 0) text += i + 1 == lines.size() ? " and " : ", ";
    text += std::to_string(line);
    ++i;
  }
  return text;
}

const Node& Model::node(const std::string& name) const {
  const auto found =
      std::find_if(nodes.begin(), nodes.end(), [&](const Node& node) { return node.name == name; });
  if (found == nodes.end()) throw std::logic_error("no node is called " + name);
  return *found;
}

}  // namespace stillframe::tools::spacar
