#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace stillframe::page {

struct ShapeNode {
  std::string name;
  Eigen::Vector3d position;  ///< m
  bool floor = false;        ///< held, or moved from outside
  double mass = 0;           ///< kg, of a mass at the node
};

enum class ShapeKind { truss, beam, rigid, hinge };
struct ShapeElement {
  std::string name;
  ShapeKind kind = ShapeKind::truss;
  std::size_t node_p = 0, node_q = 0;  ///< indices into nodes
};

struct ModeShape {
  double frequency_hz = 0;              ///< Hz
  std::optional<double> damping_ratio;  ///< 1
  Eigen::MatrixX3d displacement;        ///< n_nodes x 3, any scale: only the shape counts
};

/// A structure and how it moves in its modes, for the animated pictures.
struct ModeShapes {
  std::vector<ShapeNode> nodes;
  std::vector<ShapeElement> elements;
  std::vector<ModeShape> modes;
  bool planar = false;  ///< seen from the front
};

}  // namespace stillframe::page
