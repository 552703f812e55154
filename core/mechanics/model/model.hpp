#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/mechanics/elements/element.hpp"
#include "core/mechanics/inertia/inertia.hpp"
#include "core/mechanics/scene/scene.hpp"

namespace stillframe {

using Eigen::Index;

/// Where the coordinates of one node part stand: below n_x the moving ones, from n_x on the fixed
/// ones, -1 where a planar scene has none. A translation is measured in the node's own orthonormal
/// basis, whose columns are its directions.
struct PartMap {
  Index size = 0;
  std::array<Index, 4> column{-1, -1, -1, -1};
  Eigen::Matrix3d basis = Eigen::Matrix3d::Identity();
  bool global_axes = true;
};

struct ModelNode {
  std::string name;
  Eigen::Vector3d position;  ///< m, of the scene as written
  PartMap translation;       ///< 3; nodes joined by a hinge share it
  PartMap rotation;          ///< 4 Euler parameters, or the angle of a planar scene, or none
  bool has_rotation() const { return rotation.size > 0; }
};

/// An element in its place: which rows its deformations have, its parts among the columns, and its
/// constitutive law sigma = sigma_0 + sigma_a + S e + S_d e'.
struct ModelElement {
  std::string name;
  std::unique_ptr<const Element> element;
  std::vector<PartMap> parts;
  std::vector<Index> row;
  std::vector<char> zero;  ///< deformations held zero
  Eigen::MatrixXd S, S_d;  ///< n_e x n_e; empty where the element resists nothing
  bool damped = false;
};

struct ModelInertia {
  std::unique_ptr<const Inertia> inertia;
  std::vector<PartMap> parts;
};

/// A constant force (N) and torque (N m) that is not a constant vector in x: it turns with its
/// node, or it is a torque on Euler parameters.
struct ModelLoad {
  Index node = 0;
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  bool follows = false;
};

/// A validated multibody model: what never changes while it moves. Immutable after make_model.
///
/// Moving nodal coordinates x (n_x) are displacements from the scene as written, in the order
///   [ dependent x^c (n_c) | dynamic x^m (n_xd) | prescribed x^m (n_rx) ],
/// and the fixed x^0 (n_0) stand behind them in virtual displacements only. Deformations e (n_e)
/// are in the order
///   [ conditions: zero e^0, dynamic e^m and prescribed e^m (n_c) | redundant e^c (n_redundant) ].
/// The partition is square: as many conditions as dependent coordinates.
/// q^d (n_d) is in the order of the scene's dofs, each a dynamic x^m or a dynamic e^m; q^r (n_r) is
/// the prescribed x^m (n_rx) and then the prescribed e^m.
struct Model {
  std::string title;
  bool planar = false;
  std::vector<ModelNode> nodes;
  std::vector<ModelElement> elements;
  std::vector<ModelInertia> inertias;

  Index n_x = 0, n_0 = 0, n_c = 0, n_xd = 0, n_rx = 0, n_r = 0, n_d = 0, n_e = 0, n_redundant = 0;

  struct Dof {
    std::string name, unit;
    bool is_deformation = false;
    Index index = 0;  ///< row of e or column of x
  };
  std::vector<Dof> dofs;
  std::vector<Index> dof_of_column;  ///< n_xd: which q^d a dynamic x^m is
  /// What a condition is: the dof of a dynamic e^m, the number of a prescribed e^m, or neither.
  struct Condition {
    Index dof = -1, prescribed = -1;
  };
  std::vector<Condition> conditions;   ///< n_c
  std::vector<Index> prescribed_rows;  ///< n_r - n_rx: rows of the prescribed e^m

  Eigen::VectorXd preload;     ///< n_e, sigma_0: N or N m
  Eigen::VectorXd load;        ///< n_x: constant nodal forces, N
  Eigen::VectorXd fixed_load;  ///< n_0: the same on fixed coordinates, which only reactions feel
  std::vector<ModelLoad> turning_loads;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< m/s^2
  /// n_e x n_d or empty, P: deformations of all elements also resist by P P^T e'.
  Eigen::MatrixXd modal_dampers;

  /// The operating point that the scene states: dofs, and prescribed motions with their rates.
  OperatingPoint operating_point = OperatingPoint::equilibrium;
  Eigen::VectorXd q_0, q_dot_0;                  ///< n_d
  Eigen::VectorXd q_r_0, q_r_dot_0, q_r_ddot_0;  ///< n_r

  /// Errors: std::invalid_argument naming the nearest name that is there, or the modes there are.
  Index node_index(const std::string& name) const;
  Index element_index(const std::string& name) const;
  /// Row of a deformation of an element in e, mode from 1.
  Index deformation_row(const std::string& element, int mode = 1) const;
  /// The element whose deformation a row of e is, and which of its deformations (from 0). Errors:
  /// std::invalid_argument.
  std::pair<size_t, Index> owner_of_row(Index row) const;
  /// Whether a row of e has a constitutive law: it is neither zero nor prescribed.
  bool is_elastic(Index row) const;
  /// Row vector (n_x + n_0) of the translation of a node along a unit direction, fixed coordinates
  /// included.
  Eigen::RowVectorXd full_translation_row(Index node, const Eigen::Vector3d& direction) const;
  /// Row vector (n_x) that takes the translation of a node along a unit direction out of x.
  Eigen::RowVectorXd translation_row(Index node, const Eigen::Vector3d& direction) const;
  /// q^r (n_r) that moves a node by one along a direction. Errors: InputError at `place` if the
  /// node is not prescribed along it.
  Eigen::VectorXd prescribed_pattern(Index node, const Eigen::Vector3d& direction,
                                     const std::string& place) const;
  /// q^r (n_r) of an input that is a motion: of a node, its angle, or a deformation. Errors:
  /// InputError if that is not prescribed.
  Eigen::VectorXd prescribed_pattern(const SceneSignal& input) const;
};

/// Builds and validates a model from a scene: partition counted and checked for singularity in the
/// scene as written. Errors: InputError naming place, nodes and elements (conditions missing or too
/// many, directions at a node that are not perpendicular, a free motion that no dof or element
/// takes up, a dof used twice).
Model make_model(const Scene& scene);

}  // namespace stillframe
