#include "tests/core/newton_euler.hpp"

namespace stillframe::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

Vector3d translation(const Model& model, const VectorXd& x, const std::string& node) {
  const Index n = model.node_index(node);
  Vector3d value;
  for (int i = 0; i < 3; ++i) value(i) = model.translation_row(n, Vector3d::Unit(i)).dot(x);
  return value;
}

Vector3d position(const Model& model, const std::string& node) {
  return model.nodes[static_cast<size_t>(model.node_index(node))].position;
}

Eigen::Quaterniond rotation(const Model& model, const VectorXd& x, const std::string& node,
                            double one) {
  const auto& map = model.nodes[static_cast<size_t>(model.node_index(node))].rotation;
  return {one + x(map.column[0]), x(map.column[1]), x(map.column[2]), x(map.column[3])};
}

/// 2 (conjugate(lambda) * rate) is the body's angular velocity as a pure quaternion, and likewise
/// for accelerations.
Vector3d body_rate(const Eigen::Quaterniond& lambda, const Eigen::Quaterniond& rate) {
  return 2.0 * (lambda.conjugate() * rate).vec();
}

/// Velocity of the material point of the body that is at offset b (body axes).
Vector3d point_velocity(const RigidState& body, const Vector3d& b) {
  return body.v + body.R * body.omega.cross(b);
}

}  // namespace

RigidState rigid_state(const Scene& scene, const Model& model, const Data& data) {
  const std::string& centre = scene.masses.front().node;
  const Eigen::Quaterniond lambda = rotation(model, data.x, centre, 1.0);
  return {position(model, centre) + translation(model, data.x, centre),
          translation(model, data.x_dot, centre),
          body_rate(lambda, rotation(model, data.x_dot, centre, 0.0)), lambda.toRotationMatrix()};
}

RigidAcceleration rigid_acceleration(const Scene& scene, const Model& model, const Data& data) {
  const std::string& centre = scene.masses.front().node;
  return {
      translation(model, data.x_ddot, centre),
      body_rate(rotation(model, data.x, centre, 1.0), rotation(model, data.x_ddot, centre, 0.0))};
}

RigidAcceleration newton_euler(const Scene& scene, const Model& model, const Data& data,
                               const VectorXd& sigma_a, const RigidState& body) {
  const SceneMass& mass = scene.masses.front();
  Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();  // world; body axes
  for (const SceneElement& leg : scene.elements) {
    if (leg.kind != SceneElement::Kind::truss) continue;
    // The scenes have the far end first.
    const Vector3d b = position(model, leg.node_q) - position(model, mass.node);
    const Vector3d far = position(model, leg.node_p) + translation(model, data.x, leg.node_p);
    const Vector3d span = body.r + body.R * b - far;
    const Vector3d rate = point_velocity(body, b) - translation(model, data.x_dot, leg.node_p);
    const double l_0 = (position(model, leg.node_q) - position(model, leg.node_p)).norm();
    const Vector3d along = span.normalized();
    const double sigma = leg.preload(0) + sigma_a(model.deformation_row(leg.name)) +
                         leg.stiffness(0, 0) * (span.norm() - l_0) +
                         leg.damping(0, 0) * along.dot(rate);
    const Vector3d pull = -sigma * along;
    force += pull;
    moment += b.cross(body.R.transpose() * pull);
  }
  for (const SceneLoad& load : scene.loads) force += load.force;
  return {force / mass.mass,
          mass.inertia.inverse() * (moment - body.omega.cross(mass.inertia * body.omega))};
}

}  // namespace stillframe::test
