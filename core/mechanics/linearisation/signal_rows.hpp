#pragma once

#include "core/mechanics/kinematics.hpp"
#include "core/mechanics/scene/quantity.hpp"

namespace stillframe {

/// An input or output with its names resolved: which row of e, or which node.
struct ResolvedSignal {
  Quantity quantity = Quantity::position;
  Index row = -1;   ///< of e, for signals of an element
  Index node = -1;  ///< for signals of a node
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  /// Outputs that come from the balance of forces: reactions, and stresses of zero or prescribed
  /// deformations.
  bool is_reaction = false;
  std::string place;
};

/// Errors: InputError for a reaction where nothing holds the node, a stress input on a rigid
/// deformation, a rotation of a node that has none.
ResolvedSignal resolve_input(const Model& model, const SceneSignal& input);
ResolvedSignal resolve_output(const Model& model, const SceneSignal& output);

/// Virtual displacement (n_x + n_0) of a node at x along or about the signal's direction: the unit
/// vector of a translation, or Lambda_s^T d / 2 of a rotation; dual to a force or torque.
Eigen::VectorXd virtual_motion(const Model& model, const Eigen::VectorXd& x,
                               const ResolvedSignal& signal);

/// Nodal forces (n_x + n_0) of a unit force along or torque about the signal's direction: the unit
/// vector, or 2 Lambda_s^T d on Euler parameters.
Eigen::VectorXd unit_force(const Model& model, const Eigen::VectorXd& x,
                           const ResolvedSignal& signal);

/// A kinematic output of a node: y = p x + v x' + a x'' to first order about the motion in data,
/// rows of n_x.
struct KinematicRows {
  Eigen::RowVectorXd p, v, a;
};
KinematicRows kinematic_rows(const Model& model, const Data& data, const ResolvedSignal& output);

/// The outputs of the nonlinear equations at the motion in data, whose stresses have to be complete
/// (reaction_stresses). A rotation is counted from the Euler parameters at x_reference. set-up.
Eigen::VectorXd nonlinear_outputs(const Model& model, const Data& data,
                                  const std::vector<ResolvedSignal>& outputs,
                                  const Eigen::VectorXd& x_reference);

}  // namespace stillframe
