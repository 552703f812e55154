#pragma once

#include "core/mechanics/elements/planar_rotation.hpp"
#include "core/mechanics/elements/rotation.hpp"
#include "core/mechanics/model/local.hpp"

namespace stillframe {

/// A load that depends on the rotation of its node: its generalised forces on the translation (3)
/// and on the rotation (4 or 1), and their derivatives to the rotation.
struct TurnedLoad {
  Eigen::Vector3d force;
  Eigen::Vector4d moment = Eigen::Vector4d::Zero();
  Eigen::Matrix<double, 3, 4> d_force = Eigen::Matrix<double, 3, 4>::Zero();
  Eigen::Matrix4d d_moment = Eigen::Matrix4d::Zero();

  /// rotation: the displacement of the node's rotation part. A torque T is dual to Euler parameters
  /// as 2 Lambda_s^T T when fixed in space, 2 Lambda^T T when it follows.
  TurnedLoad(const ModelLoad& load, const LocalVector& rotation, bool planar) noexcept
      : force(load.force) {
    if (planar) {
      moment(0) = load.torque.z();
      force += turned_by(rotation(0), load.force);
      d_force.col(0) = quarter_turned(force);
      return;
    }
    const Vector4 lambda = euler_parameters(rotation);
    if (load.follows) {
      force += rotation_form(lambda, lambda, load.force);
      d_force = d_rotated_d_lambda(lambda, load.force);
      moment = 2.0 * body_rate_matrix(lambda).transpose() * load.torque;
      d_moment = 2.0 * d_body_rate_dual(load.torque);
    } else {
      moment = 2.0 * space_rate_matrix(lambda).transpose() * load.torque;
      d_moment = 2.0 * d_space_rate_dual(load.torque);
    }
  }
};

/// The displacement of a node's rotation part, 0 where x does not hold it. hot.
inline LocalVector rotation_displacement(const ModelNode& node, const Eigen::VectorXd& x) noexcept {
  LocalVector rotation = LocalVector::Zero(node.rotation.size);
  for (Index i = 0; i < rotation.size(); ++i) {
    const Index column = node.rotation.column[static_cast<size_t>(i)];
    if (column >= 0 && column < x.size()) rotation(i) = x(column);
  }
  return rotation;
}

/// f += factor times the loads that turn, at the positions x; of rows below n. hot.
inline void add_turning_loads(const Model& model, const Eigen::VectorXd& x, double factor, Index n,
                              Eigen::VectorXd& f) noexcept {
  const auto add = [&](const PartMap& map, const double* values) {
    for (Index i = 0; i < map.size; ++i) {
      const Index column = map.column[static_cast<size_t>(i)];
      if (column >= 0 && column < n) f(column) += factor * values[i];
    }
  };
  for (const ModelLoad& load : model.turning_loads) {
    const ModelNode& node = model.nodes[static_cast<size_t>(load.node)];
    const TurnedLoad turned(load, rotation_displacement(node, x), model.planar);
    const Eigen::Vector3d force = node.translation.basis.transpose() * turned.force;
    add(node.translation, force.data());
    add(node.rotation, turned.moment.data());
  }
}

/// The parts a turning load acts on: translation, then rotation.
inline std::vector<PartMap> parts_of(const Model& model, const ModelLoad& load) {
  const ModelNode& node = model.nodes[static_cast<size_t>(load.node)];
  return {node.translation, node.rotation};
}

}  // namespace stillframe
