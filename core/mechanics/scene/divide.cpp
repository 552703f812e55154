#include "core/mechanics/scene/divide.hpp"

#include <algorithm>

namespace stillframe {

void add_divided(const SceneElement& element, std::int64_t n, Scene& scene) {
  if (n == 1) {
    scene.elements.push_back(element);
    return;
  }
  const auto position = [&](const std::string& name) {
    return std::find_if(scene.nodes.begin(), scene.nodes.end(),
                        [&](const SceneNode& node) { return node.name == name; })
        ->position;
  };
  const Eigen::Vector3d p = position(element.node_p), q = position(element.node_q);
  SceneElement part = element;
  for (std::int64_t i = 1; i <= n; ++i) {
    part.name = element.name + "/" + std::to_string(i);
    part.node_q = i == n ? element.node_q : part.name;
    if (i < n) {
      const double along = static_cast<double>(i) / static_cast<double>(n);
      scene.nodes.push_back({part.name, element.place, p + (q - p) * along});
    }
    scene.elements.push_back(part);
    part.node_p = part.node_q;
  }
}

}  // namespace stillframe
