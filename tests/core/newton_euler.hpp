#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/scene/scene.hpp"

namespace stillframe::test {

/// Where one rigid body is and how it moves: r, v in the world, R body to world, omega in body
/// axes.
struct RigidState {
  Eigen::Vector3d r, v, omega;
  Eigen::Matrix3d R;
};

struct RigidAcceleration {
  Eigen::Vector3d linear;   ///< world, m/s^2
  Eigen::Vector3d angular;  ///< body, rad/s^2
};

/// Newton's and Euler's equations of the body at node `centre` that hangs on the trusses of a
/// scene: forces along the trusses as they lie now, the far ends as the model's data say. Knows
/// nothing of deformations, conditions or dofs.
RigidAcceleration newton_euler(const Scene& scene, const Model& model, const Data& data,
                               const Eigen::VectorXd& sigma_a, const RigidState& body);

/// Reads the body's state and its acceleration off the nodal coordinates that accelerations() left
/// in data.
RigidState rigid_state(const Scene& scene, const Model& model, const Data& data);
RigidAcceleration rigid_acceleration(const Scene& scene, const Model& model, const Data& data);

}  // namespace stillframe::test
