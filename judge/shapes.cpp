#include "judge/shapes.hpp"

#include <algorithm>

#include "core/mechanics/modes.hpp"
#include "core/mechanics/node_displacements.hpp"
#include "core/mechanics/operating_point.hpp"

namespace stillframe::judge {

namespace {

/// The positions of all nodes, three outputs each.
std::vector<SceneSignal> all_positions(const Scene& scene) {
  std::vector<SceneSignal> outputs;
  for (const SceneNode& node : scene.nodes) {
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
    case SceneElement::Kind::truss:
      break;
  }
  return page::ShapeKind::truss;
}

std::size_t index_of(const Scene& scene, const std::string& name) {
  const auto place = std::find_if(scene.nodes.begin(), scene.nodes.end(),
                                  [&](const SceneNode& node) { return node.name == name; });
  return static_cast<std::size_t>(place - scene.nodes.begin());
}

void add_structure(const Scene& scene, const Model& model, const LinearModel& linear,
                   page::ModeShapes& shapes) {
  const auto displacements = node_displacements(model, linear.x_0);
  const Index size = scene.planar ? 2 : 3;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const SceneNode& node = scene.nodes[i];
    const auto displaced =
        std::find_if(displacements.begin(), displacements.end(),
                     [&](const NodeDisplacement& item) { return item.node == node.name; });
    const bool held = linear.Y_p.middleRows(size * static_cast<Index>(i), size).isZero(0);
    page::ShapeNode shape{.name = node.name, .position = node.position, .floor = held, .mass = 0};
    if (displaced != displacements.end()) shape.position += displaced->displacement;
    shapes.nodes.push_back(shape);
  }
  for (const SceneMass& mass : scene.masses) {
    shapes.nodes[index_of(scene, mass.node)].mass += mass.mass;
  }
  for (const SceneElement& element : scene.elements) {
    shapes.elements.push_back({element.name, kind_of(element.kind), index_of(scene, element.node_p),
                               index_of(scene, element.node_q)});
  }
}

}  // namespace

std::optional<page::ModeShapes> mode_shapes(const Scene& scene, const Model& model,
                                            Eigen::Index most_modes) {
  const LinearModel linear = linearise(model, nominal_motion(model), {}, all_positions(scene));
  const Modes result = modes(linear);
  if (result.natural_frequencies_hz.size() == 0) return std::nullopt;
  page::ModeShapes shapes;
  shapes.planar = scene.planar;
  add_structure(scene, model, linear, shapes);
  const Index size = scene.planar ? 2 : 3;
  for (Index i = 0; i < std::min(most_modes, result.natural_frequencies_hz.size()); ++i) {
    page::ModeShape mode;
    mode.frequency_hz = result.natural_frequencies_hz(i);
    if (!linear.D.isZero(0)) mode.damping_ratio = result.damping_ratios(i);
    const Eigen::VectorXd moved = linear.Y_p * result.shapes.col(i);
    mode.displacement.setZero(static_cast<Index>(scene.nodes.size()), 3);
    for (Index node = 0; node < mode.displacement.rows(); ++node) {
      mode.displacement.row(node).head(size) = moved.segment(size * node, size).transpose();
    }
    shapes.modes.push_back(mode);
  }
  return shapes;
}

}  // namespace stillframe::judge
