#include "tools/unit_hint.hpp"

#include <iostream>
#include <map>

#include "core/errors/formatted.hpp"
#include "core/files/utf8.hpp"

namespace stillframe::tools {

void hint_at_units(const Scene& scene) {
  std::map<std::string, Eigen::Vector3d> positions;
  for (const SceneNode& node : scene.nodes) positions[node.name] = node.position;
  const SceneElement* longest = nullptr;
  double length = longest_likely_m;
  for (const SceneElement& element : scene.elements) {
    if (element.superelement) continue;
    const double own = (positions[element.node_q] - positions[element.node_p]).norm();
    if (own < length) continue;
    length = own;
    longest = &element;
  }
  if (longest == nullptr) return;
  std::cerr << "stillframe: note: " << longest->place << ": " << printable(longest->name, 60)
            << " is " << formatted("%.4g", length)
            << " m long; if its nodes are in millimetres, write metres: every number of a scene is "
               "in SI units\n";
}

}  // namespace stillframe::tools
