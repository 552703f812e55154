#include "judge/shapes.hpp"

#include <algorithm>

#include "core/mechanics/modes.hpp"
#include "core/mechanics/node_displacements.hpp"
#include "core/mechanics/operating_point.hpp"

namespace stillframe::judge {

namespace {

/// All that are somewhere.
std::vector<SceneNode> drawn_nodes(const Scene& scene) {
  std::vector<SceneNode> nodes;
  for (const SceneNode& node : scene.nodes) {
    if (!node.amplitudes) nodes.push_back(node);
  }
  return nodes;
}

/// The positions of nodes, three outputs each.
std::vector<SceneSignal> positions_of(const Scene& scene, const std::vector<SceneNode>& nodes) {
  std::vector<SceneSignal> outputs;
  for (const SceneNode& node : nodes) {
    for (int axis = 0; axis < 3; ++axis) {
      if (scene.planar && axis == 2) continue;
      SceneSignal signal;
      signal.name = node.name;
      signal.place = node.place;
      signal.node = node.name;
      signal.direction = Eigen::Vector3d::Unit(axis);
      outputs.push_back(signal);
    }
  }
  return outputs;
}

page::ShapeKind kind_of(SceneElement::Kind kind) {
  switch (kind) {
    case SceneElement::Kind::beam:
      return page::ShapeKind::beam;
    case SceneElement::Kind::rigid_beam:
      return page::ShapeKind::rigid;
    case SceneElement::Kind::hinge:
      return page::ShapeKind::hinge;
    case SceneElement::Kind::superelement:
      return page::ShapeKind::beam;
    case SceneElement::Kind::truss:
      break;
  }
  return page::ShapeKind::truss;
}

std::size_t index_of(const std::vector<SceneNode>& nodes, const std::string& name) {
  const auto place = std::find_if(nodes.begin(), nodes.end(),
                                  [&](const SceneNode& node) { return node.name == name; });
  return static_cast<std::size_t>(place - nodes.begin());
}

/// The pairs of nodes between which an element is drawn: a superelement as a star.
std::vector<std::pair<std::string, std::string>> lines_of(const SceneElement& element) {
  if (!element.superelement) return {{element.node_p, element.node_q}};
  const auto& nodes = element.superelement->nodes;
  std::vector<std::pair<std::string, std::string>> lines;
  for (std::size_t k = 1; k < nodes.size(); ++k) lines.emplace_back(nodes.front(), nodes[k]);
  return lines;
}

void add_structure(const Scene& scene, const std::vector<SceneNode>& nodes, const Model& model,
                   const LinearModel& linear, page::ModeShapes& shapes) {
  const auto displacements = node_displacements(model, linear.x_0);
  const Index size = scene.planar ? 2 : 3;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const SceneNode& node = nodes[i];
    const auto displaced =
        std::find_if(displacements.begin(), displacements.end(),
                     [&](const NodeDisplacement& item) { return item.node == node.name; });
    const bool held = linear.Y_p.middleRows(size * static_cast<Index>(i), size).isZero(0);
    page::ShapeNode shape{.name = node.name, .position = node.position, .floor = held, .mass = 0};
    if (displaced != displacements.end()) shape.position += displaced->displacement;
    shapes.nodes.push_back(shape);
  }
  for (const SceneMass& mass : scene.masses) {
    shapes.nodes[index_of(nodes, mass.node)].mass += mass.mass;
  }
  for (const SceneElement& element : scene.elements) {
    for (const auto& [p, q] : lines_of(element)) {
      shapes.elements.push_back(
          {element.name, kind_of(element.kind), index_of(nodes, p), index_of(nodes, q)});
    }
  }
}

}  // namespace

std::optional<page::ModeShapes> mode_shapes(const Scene& scene, const Model& model,
                                            Eigen::Index most_modes) {
  const std::vector<SceneNode> nodes = drawn_nodes(scene);
  const LinearModel linear =
      linearise(model, nominal_motion(model), {}, positions_of(scene, nodes));
  const Modes result = modes(linear);
  if (result.natural_frequencies_hz.size() == 0) return std::nullopt;
  page::ModeShapes shapes;
  shapes.planar = scene.planar;
  add_structure(scene, nodes, model, linear, shapes);
  const Index size = scene.planar ? 2 : 3;
  for (Index i = 0; i < std::min(most_modes, result.natural_frequencies_hz.size()); ++i) {
    page::ModeShape mode;
    mode.frequency_hz = result.natural_frequencies_hz(i);
    if (!linear.D.isZero(0)) mode.damping_ratio = result.damping_ratios(i);
    const Eigen::VectorXd moved = linear.Y_p * result.shapes.col(i);
    mode.displacement.setZero(static_cast<Index>(nodes.size()), 3);
    for (Index node = 0; node < mode.displacement.rows(); ++node) {
      mode.displacement.row(node).head(size) = moved.segment(size * node, size).transpose();
    }
    shapes.modes.push_back(mode);
  }
  return shapes;
}

}  // namespace stillframe::judge
