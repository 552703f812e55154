#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/mechanics/scene/disturbances.hpp"
#include "core/mechanics/scene/plant_methods.hpp"
#include "core/systems/instruments.hpp"
#include "core/systems/realisation.hpp"

// A scene as a person wrote it, checked key by key; names are not resolved yet. `place` is
// "file:line:column".
namespace stillframe {

struct SceneNode {
  std::string name, place;
  Eigen::Vector3d position;  ///< m; planar scenes: z = 0
  /// Its translations are the amplitudes of three modes of a superelement: it is nowhere.
  bool amplitudes = false;
};

struct SceneMass {
  std::string node, place;
  double mass = 0;          ///< kg
  Eigen::Matrix3d inertia;  ///< kg m^2 about the node, global axes of the scene as written; planar
                            ///< scenes: the zz entry alone
  bool has_inertia = false;
};

/// Section of a beam. Stiffnesses of rigid deformations stay 0.
struct SceneBeam {
  double EA = 0;                    ///< N
  double GJ = 0;                    ///< N m^2
  double EI_y = 0, EI_z = 0;        ///< N m^2: bending in the n_x-n_z and the n_x-n_y plane; planar
                                    ///< scenes: EI_z alone
  double shear_y = 0, shear_z = 0;  ///< N, k G A along n_y and n_z; 0: not flexible in shear
  double mass_per_length = 0;       ///< kg/m
  double inertia_per_length = 0;    ///< kg m, about the axis of the beam
  double damping_time = 0;          ///< s, S_d = damping_time S
  bool lumped_mass = false;         ///< half at each end instead of consistent
  bool second_order = false;        ///< second-order terms in the deformations
  Eigen::Vector3d orientation = Eigen::Vector3d::Zero();  ///< spans the n_x-n_y plane with n_x
};

struct ReadFile {
  std::string path, bytes;
};

/// A flexible body between its interface nodes, in the axes of the scene.
struct SceneSuperelement {
  std::vector<std::string> nodes, mode_nodes;
  Eigen::Matrix3Xd s;  ///< m, from the first node to each
  Eigen::MatrixXd M;   ///< as SuperelementMass has it
  Eigen::Index n_modes = 0;
  double damping_time = 0;      ///< s
  std::vector<ReadFile> files;  ///< the body file and its matrices, from where the program runs
};

struct SceneElement {
  enum class Kind { truss, beam, rigid_beam, hinge, superelement };
  std::string name, place;
  Kind kind = Kind::truss;
  std::string node_p, node_q;
  /// From its nodes to its ends, m, fixed to the nodes (merge_rigid_bodies): of trusses in space.
  Eigen::Vector3d arm_p = Eigen::Vector3d::Zero(), arm_q = Eigen::Vector3d::Zero();
  /// Number of deformations n_e: truss 1; beam and rigid_beam 6, planar 3; hinge 3, planar 1;
  /// superelement 6 for every interface but the first, and 1 a mode.
  Eigen::Index n_deformations = 1;
  std::vector<bool> zero;     ///< n_e, deformations that are held zero
  Eigen::MatrixXd stiffness;  ///< n_e x n_e, S; of a beam what is added to its section's
  Eigen::MatrixXd damping;    ///< n_e x n_e, S_d; of a beam what is added to its section's
  Eigen::VectorXd preload;    ///< n_e, stress resultants sigma_0 of the scene as written
  SceneBeam beam;             ///< of a beam
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of a hinge
  std::shared_ptr<const SceneSuperelement> superelement;

  bool rigid() const {
    return std::all_of(zero.begin(), zero.end(), [](bool held) { return held; });
  }
};

/// What holds (supports) or moves (prescribed) coordinates of one node, or what moves one
/// deformation of an element; value, rate and acceleration are those of the operating point.
struct SceneConstraint {
  std::string node, place;
  std::vector<Eigen::Vector3d> directions;
  bool rotation = false;  ///< supports, and prescribed motion in planar scenes
  std::string element;
  int mode = 0;                                  ///< of the element, from 1
  double value = 0, rate = 0, acceleration = 0;  ///< SI, rad
};

/// A degree of freedom: a deformation of an element, a translation of a node along a direction, the
/// rotation of a node of a planar scene, or the Euler parameter lambda_0 to lambda_3 of a node.
/// value and rate are those of the operating point of a scene `as_written`.
struct SceneDof {
  std::string place, element, node;
  int mode = 0;  ///< of the element, from 1
  std::optional<Eigen::Vector3d> direction;
  int euler_parameter = -1;  ///< 0 to 3, or -1
  bool rotation = false;
  double value = 0, rate = 0;
};

/// A constant nodal force (N) and torque (N m), fixed in space or turning with the node.
struct SceneLoad {
  std::string node, place;
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  bool follows = false;
};

enum class Quantity {
  position,
  velocity,
  acceleration,  ///< of a node along a direction
  rotation,
  angular_velocity,
  angular_acceleration,  ///< of a node about a direction
  force,
  torque,  ///< on a node along or about a direction
  stress,
  deformation,
  deformation_rate,
  deformation_acceleration,  ///< of an element
  reaction,
  reaction_moment  ///< what a support or a prescribed motion exerts on a node
};

/// An input or output of the linear models: a quantity of a node along a direction, or of one
/// deformation of an element.
struct SceneSignal {
  std::string name, place, node, element;
  Quantity quantity = Quantity::position;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  int mode = 1;  ///< of the element, from 1
};

/// One line of the verdict's table: what moves below against what moves above.
struct SceneComparison {
  std::string name, place, floor, frame;
};

enum class GainOrder { exact, deck };
/// Which motion of the frame stands for the elongations of fewer legs than dofs: the slowest modes,
/// or the motion of least strain energy.
enum class Reduction { modes, static_shapes };

/// What a feed-forward from the floor is to do (core/control/feed_forward_design.hpp).
struct SceneFeedForward {
  double to_hz = 0, corner_hz = 0;
  /// Of the motion that it aims at; nothing: those of the feedback.
  std::optional<double> target_hz, damping_ratio;
  double at_most_db = -10;
  double actuator_error = 0.02, noise_over_floor = 1e-3;
  int taps = 16;
};

/// A law of one's own, as it stands in its file; judge/law_file.hpp reads it.
struct SceneLaw {
  std::string file, bytes;
};

struct SceneController {
  std::string place;
  std::vector<std::string> legs;
  /// One number for all virtual modes, or one for each, slowest mode of the frame first.
  std::vector<double> target_hz, damping_ratio;
  GainOrder order = GainOrder::exact;
  Reduction reduction = Reduction::static_shapes;
  Realisation realisation = Realisation::implicit_feedthrough;
  double sample_rate_hz = 0;
  double delay_samples = 0;
  double leak_hz = 0;
  double high_pass_hz = 0;
  double lead_samples = 0;
  std::optional<double> roll_off_hz, force_limit_n;
  std::optional<SceneFeedForward> feed_forward;
  std::optional<SceneLaw> law;

  /// The lowest target and its damping, for what has room for one number only.
  double lowest_target_hz() const { return *std::min_element(target_hz.begin(), target_hz.end()); }
};

/// By how much the plant may differ from its model, each way; 0: not at all. Legs vary one by one.
struct SceneUncertainty {
  std::string place;
  double stiffness = 0;          ///< of each leg, relative
  double damping = 0;            ///< of each leg that has some, relative
  double mass = 0, inertia = 0;  ///< of each mass, relative
  double centre_of_mass_m = 0;   ///< of each mass that carries no leg, along x, y and z
  double leg_direction_rad = 0;  ///< of each leg, about both axes across it
  double actuator_gain = 0;      ///< of each actuator, relative
  double sensor_gain = 0;        ///< of each force sensor, relative
  double delay_samples = 0;      ///< of all commands
};

struct SceneSimulation {
  std::string place;
  double duration_s = 0;  ///< 0: as long as the floor lasts
  double relative_tolerance = 1e-5;
  PlantMethod method = PlantMethod::automatic;
};

/// `reduce`: on how many of its lowest modes a linear model is to stand. One of the three at least
/// is said, 0: nothing.
struct SceneReduction {
  Eigen::Index n_modes = 0;
  double modes_to_hz = 0;  ///< all up to there
  double to_hz = 0;        ///< up to where it is to be right
  std::string place;
};

/// `modal_damping`: the damping ratio of a natural mode of the operating point by its frequency;
/// linear in between, and outside that of the nearest.
struct SceneModalDamping {
  struct Point {
    double hz = 0, ratio = 0;
  };
  std::vector<Point> points;  ///< one and more, hz rising
  std::string place;

  double ratio_at(double hz) const {
    const auto above = std::find_if(points.begin(), points.end(),
                                    [hz](const Point& point) { return point.hz > hz; });
    if (above == points.begin()) return points.front().ratio;
    if (above == points.end()) return points.back().ratio;
    const Point &from = *(above - 1), &to = *above;
    return from.ratio + (to.ratio - from.ratio) * (hz - from.hz) / (to.hz - from.hz);
  }
};

enum class OperatingPoint { equilibrium, as_written };

struct Scene {
  std::string title, file, text, hash;
  std::string bodies_hash;  ///< of the files of superelements, empty if there are none
  bool planar = false;      ///< all motion in the x-y plane, rotations about z
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< m/s^2
  OperatingPoint operating_point = OperatingPoint::equilibrium;
  std::vector<SceneNode> nodes;
  std::vector<SceneMass> masses;
  std::vector<SceneElement> elements;
  std::vector<SceneConstraint> supports, prescribed;
  std::vector<SceneDof> dofs;
  bool automatic_dofs = false;  ///< the model chooses nodal coordinates
  std::string dofs_place;
  std::vector<SceneLoad> loads;
  std::vector<SceneSignal> inputs, outputs, monitors;
  std::vector<SceneComparison> comparisons;
  std::optional<SceneController> controller;
  Instruments instruments;
  std::vector<SceneDisturbance> disturbances;
  std::optional<SceneUncertainty> uncertainty;
  SceneSimulation simulation;
  std::optional<SceneReduction> reduction;
  std::optional<SceneModalDamping> modal_damping;
};

}  // namespace stillframe
