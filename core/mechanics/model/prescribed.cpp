#include "core/mechanics/model/prescribed.hpp"

#include <algorithm>

#include "core/errors/formatted.hpp"

namespace stillframe {

std::string direction_in_words(const Eigen::Vector3d& direction) {
  for (Index i = 0; i < 3; ++i) {
    if (direction == Eigen::Vector3d::Unit(i)) return std::string(1, "xyz"[i]);
  }
  return formatted("[%.4g, %.4g, %.4g]", direction.x(), direction.y(), direction.z());
}

std::vector<SceneSignal> prescribed_signals(const Model& model) {
  std::vector<SceneSignal> signals(static_cast<size_t>(model.n_r));
  const Index first = model.n_x - model.n_rx;
  const auto of_column = [&](Index column) -> SceneSignal* {
    if (column < first || column >= model.n_x) return nullptr;
    SceneSignal& signal = signals[static_cast<size_t>(column - first)];
    return signal.node.empty() ? &signal : nullptr;  // nodes joined by a hinge share theirs
  };
  for (const ModelNode& node : model.nodes) {
    for (int i = 0; i < 3; ++i) {
      if (SceneSignal* signal = of_column(node.translation.column[static_cast<size_t>(i)])) {
        signal->node = node.name;
        signal->direction = node.translation.basis.col(i);
        signal->name = node.name + " along " + direction_in_words(signal->direction);
      }
    }
    if (SceneSignal* signal = of_column(node.rotation.column[0])) {
      signal->node = node.name;
      signal->quantity = Quantity::rotation;
      signal->direction = Eigen::Vector3d::UnitZ();
      signal->name = node.name + " (rotation)";
    }
  }
  for (size_t i = 0; i < model.prescribed_rows.size(); ++i) {
    SceneSignal& signal = signals[static_cast<size_t>(model.n_rx) + i];
    const auto [element, mode] = model.owner_of_row(model.prescribed_rows[i]);
    signal.element = signal.name = model.elements[element].name;
    signal.mode = static_cast<int>(mode) + 1;
    signal.quantity = Quantity::deformation;
    if (mode > 0) signal.name += " (mode " + std::to_string(signal.mode) + ")";
  }
  return signals;
}

bool is_angle(const Model& model, const SceneSignal& signal) {
  if (signal.element.empty()) return signal.quantity == Quantity::rotation;
  const auto element = static_cast<size_t>(model.element_index(signal.element));
  const auto& parts = model.elements[element].element->parts();
  return std::none_of(parts.begin(), parts.end(), [](const NodePart& part) {
    return part.kind == NodePart::Kind::translation;
  });
}

}  // namespace stillframe
