#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/elements/element.hpp"
#include "core/scene/scene.hpp"

namespace stillframe {

using Eigen::Index;

/// Where the coordinates of one node part stand among the moving coordinates; -1 for a fixed one.
/// A translation is measured in the node's own orthonormal basis, whose columns are its directions.
struct PartMap {
  std::array<Index, 4> column{-1, -1, -1, -1};
  Eigen::Matrix3d basis = Eigen::Matrix3d::Identity();
  bool global_axes = true;
};

struct ModelNode {
  std::string name;
  Eigen::Vector3d position;  ///< m, of the scene as written
  PartMap translation, rotation;
  bool has_rotation = false;
};

/// An element in its place: which rows its deformations have, and its parts among the columns.
struct ModelElement {
  std::string name;
  std::unique_ptr<const Element> element;
  std::vector<PartMap> parts;
  std::array<Index, max_deformations> row{};
  bool elastic = false;
};

struct LumpedMass {
  Index node = 0;
  double mass = 0;          ///< kg
  Eigen::Matrix3d inertia;  ///< kg m^2
  bool has_inertia = false;
};

/// A validated multibody model: what never changes while it moves. Immutable after make_model.
///
/// Moving nodal coordinates x (n_x) are displacements from the scene as written, in the order
///   [ dependent x^c (n_c) | dynamic x^m (n_xd) | prescribed x^m = q^r (n_r) ],
/// fixed ones x^0 are left out. Deformations e (n_e) are in the order
///   [ conditions: zero e^0 and dynamic e^m (n_c) | redundant elastic e^c (n_redundant) ].
/// The partition is square: as many conditions as dependent coordinates.
/// q^d (n_d) is in the order of the scene's dofs, each a dynamic x^m or a dynamic e^m.
struct Model {
  std::string title;
  std::vector<ModelNode> nodes;
  std::vector<ModelElement> elements;
  std::vector<LumpedMass> masses;

  Index n_x = 0, n_c = 0, n_xd = 0, n_r = 0, n_d = 0, n_e = 0, n_redundant = 0;

  struct Dof {
    std::string name, unit;
    bool is_deformation = false;
    Index index = 0;  ///< row of e or column of x
  };
  std::vector<Dof> dofs;

  Eigen::VectorXd stiffness, damping, preload;  ///< n_e: N/m, N s/m, N; zero for e^0
  Eigen::VectorXd load;                         ///< n_x: constant nodal forces, N

  Index node_index(const std::string& name) const;
  Index element_index(const std::string& name) const;
  /// Row of an elastic element's elongation in e.
  Index elastic_row(const std::string& element) const;
  /// Row vector (n_x) that takes the translation of a node along a unit direction out of x.
  Eigen::RowVectorXd translation_row(Index node, const Eigen::Vector3d& direction) const;
  /// q^r (n_r) that moves a node by one along a direction. Errors: InputError at `place` if the
  /// node is not prescribed along it.
  Eigen::VectorXd prescribed_pattern(Index node, const Eigen::Vector3d& direction,
                                     const std::string& place) const;
};

/// Builds and validates a model from a scene: partition counted and checked for singularity in the
/// scene as written. Errors: InputError naming place, nodes and elements (conditions missing or too
/// many, directions at a node that are not perpendicular, a free motion that no dof or element
/// takes up, a dof used twice).
Model make_model(const Scene& scene);

}  // namespace stillframe
