#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

// A scene as a person wrote it, checked key by key; names are not resolved yet. `place` is
// "file:line:column".
namespace stillframe {

struct SceneNode {
  std::string name, place;
  Eigen::Vector3d position;  ///< m
};

struct SceneMass {
  std::string node, place;
  double mass = 0;          ///< kg
  Eigen::Matrix3d inertia;  ///< kg m^2 about the node, global axes of the scene as written
  bool has_inertia = false;
};

struct SceneElement {
  enum class Kind { truss, rigid_beam };
  std::string name, place;
  Kind kind = Kind::truss;
  std::string node_p, node_q;
  bool rigid = false;
  double stiffness = 0;  ///< N/m
  double damping = 0;    ///< N s/m
  double preload = 0;    ///< N, stress resultant of the scene as written
};

/// Fixed (supports) or prescribed coordinates of one node.
struct SceneConstraint {
  std::string node, place;
  std::vector<Eigen::Vector3d> directions;
  bool rotation = false;
};

/// A degree of freedom: the deformation of an element, a translation of a node along a direction,
/// or the Euler parameter lambda_1, lambda_2 or lambda_3 of a node.
struct SceneDof {
  std::string place, element, node;
  std::optional<Eigen::Vector3d> direction;
  int euler_parameter = 0;  ///< 1, 2 or 3, or 0
};

/// A constant nodal force, N, fixed in space.
struct SceneLoad {
  std::string node, place;
  Eigen::Vector3d force;
};

enum class Quantity { position, velocity, acceleration, force, stress, deformation };

/// An input or output of the linear models: a quantity of a node along a direction, or of an
/// element.
struct SceneSignal {
  std::string name, place, node, element;
  Quantity quantity = Quantity::position;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
};

/// One line of the verdict's table: what moves below against what moves above.
struct SceneComparison {
  std::string name, place, floor, frame;
};

enum class GainOrder { exact, deck };
enum class Realisation { implicit_feedthrough, naive_pi };

struct SceneController {
  std::string place;
  std::vector<std::string> legs;
  double target_hz = 0, damping_ratio = 0;
  GainOrder order = GainOrder::exact;
  Realisation realisation = Realisation::implicit_feedthrough;
  double sample_rate_hz = 0;
  int delay_samples = 0;
  double leak_hz = 0;
  double lead_samples = 0;
  std::optional<double> roll_off_hz, force_limit_n;
};

struct SceneSimulation {
  double duration_s = 0;  ///< 0: as long as the floor lasts
  double relative_tolerance = 1e-5;
};

struct Scene {
  std::string title, file, text, hash;
  std::vector<SceneNode> nodes;
  std::vector<SceneMass> masses;
  std::vector<SceneElement> elements;
  std::vector<SceneConstraint> supports, prescribed;
  std::vector<SceneDof> dofs;
  std::string dofs_place;
  std::vector<SceneLoad> loads;
  std::vector<SceneSignal> inputs, outputs, monitors;
  std::vector<SceneComparison> comparisons;
  std::optional<SceneController> controller;
  SceneSimulation simulation;
};

}  // namespace stillframe
