#include "bench/large_motion/describe.hpp"

#include <map>
#include <stdexcept>

#include "core/mechanics/elements/rotation.hpp"

namespace stillframe::race {

namespace {

using Kind = SceneElement::Kind;

/// Which nodes are one rigid body: joined by rigid beams.
class Groups {
 public:
  explicit Groups(const Scene& scene) {
    for (const SceneNode& node : scene.nodes) of_[node.name] = node.name;
    for (const SceneElement& element : scene.elements) {
      if (element.kind == Kind::rigid_beam) join(element.node_p, element.node_q);
    }
  }
  const std::string& of(const std::string& node) const { return of_.at(node); }

 private:
  void join(const std::string& a, const std::string& b) {
    const std::string from = of_.at(b), to = of_.at(a);
    for (auto& [node, group] : of_) {
      if (group == from) group = to;
    }
  }
  std::map<std::string, std::string> of_;
};

class Description {
 public:
  explicit Description(const Scene& scene) : scene_(scene), groups_(scene) {
    for (const SceneNode& node : scene.nodes) position_[node.name] = node.position;
    result_.gravity = scene.gravity;
    result_.sample_time = 1 / scene.controller->sample_rate_hz;
    add_bodies();
    for (const SceneElement& element : scene.elements) {
      if (element.kind == Kind::truss) add_spring(element);
    }
    for (const SceneConstraint& support : scene.supports) add_guides(support);
    for (const SceneSignal& output : scene.outputs) {
      result_.outputs.push_back({point(output.node), output.direction});
    }
    for (const SceneSignal& input : scene.inputs) {
      const bool moves_spring = result_.bodies.front().joint == "free";
      result_.base_inputs.push_back(moves_spring ? Eigen::Vector3d::Zero() : input.direction);
    }
  }
  const Mechanism& result() const { return result_; }

 private:
  Point point(const std::string& node) const {
    const auto found = body_.find(groups_.of(node));
    return {found == body_.end() ? -1 : found->second, position_.at(node)};
  }

  void add_bodies() {
    // Hinges in a row: a body's parent stands before it.
    for (const SceneElement& hinge : scene_.elements) {
      if (hinge.kind != Kind::hinge) continue;
      RigidBody body = with_masses(groups_.of(hinge.node_q));
      body.joint = "pin";
      body.parent = point(hinge.node_p).body;
      body.hinge = position_.at(hinge.node_q);
      body.axis = scene_.planar ? Eigen::Vector3d::UnitZ() : hinge.axis.normalized();
      if (hinge.stiffness.size() > 0) body.stiffness = hinge.stiffness(0, 0);
      if (hinge.damping.size() > 0) body.damping = hinge.damping(0, 0);
      place(hinge.node_q, body);
    }
    if (!result_.bodies.empty()) return;
    const std::string& node = scene_.masses.at(0).node;
    RigidBody body = with_masses(groups_.of(node));
    body.joint = "free";
    body.hinge = body.axis = Eigen::Vector3d::Zero();
    place(node, body);
  }
  void place(const std::string& node, const RigidBody& body) {
    body_[groups_.of(node)] = static_cast<int>(result_.bodies.size());
    result_.bodies.push_back(body);
  }
  RigidBody with_masses(const std::string& group) const {
    RigidBody body;
    body.centre.setZero();
    body.J.setZero();
    for (const SceneMass& mass : scene_.masses) {
      if (groups_.of(mass.node) != group) continue;
      body.mass += mass.mass;
      body.centre += mass.mass * position_.at(mass.node);
    }
    if (!(body.mass > 0)) throw std::invalid_argument("a body without mass");
    body.centre /= body.mass;
    for (const SceneMass& mass : scene_.masses) {
      if (groups_.of(mass.node) != group) continue;
      const Eigen::Matrix3d across = cross_matrix(position_.at(mass.node) - body.centre);
      body.J += mass.inertia - mass.mass * across * across;
    }
    // A planar scene knows of turns about z alone; the others have to be a body's.
    if (scene_.planar) {
      body.J(0, 0) = body.J(1, 1) = body.J(2, 2);
    }
    return body;
  }
  void add_spring(const SceneElement& truss) {
    Spring spring{point(truss.node_p), point(truss.node_q), 0, 0, -1, Eigen::Vector3d::Zero()};
    if (truss.stiffness.size() > 0) spring.stiffness = truss.stiffness(0, 0);
    if (truss.damping.size() > 0) spring.damping = truss.damping(0, 0);
    for (std::size_t i = 0; i < scene_.inputs.size(); ++i) {
      if (spring.from.body >= 0 || scene_.inputs[i].node != truss.node_p) continue;
      if (result_.bodies.front().joint != "free") continue;
      spring.input = static_cast<int>(i);
      spring.direction = scene_.inputs[i].direction;
    }
    result_.springs.push_back(spring);
  }
  void add_guides(const SceneConstraint& support) {
    const Point held = point(support.node);
    if (held.body < 0) return;
    for (const Eigen::Vector3d& direction : support.directions) {
      if (scene_.planar && direction.z() != 0) continue;
      result_.guides.push_back({held, direction});
    }
  }

  const Scene& scene_;
  Groups groups_;
  std::map<std::string, Eigen::Vector3d> position_;
  std::map<std::string, int> body_;
  Mechanism result_;
};

}  // namespace

Mechanism mechanism_of(const Scene& scene) { return Description(scene).result(); }

}  // namespace stillframe::race
