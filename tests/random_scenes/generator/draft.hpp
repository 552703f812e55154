#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tests/random_scenes/generator/draws.hpp"

namespace stillframe::random_scenes {

/// A rigid body, or a point mass, that legs carry.
struct Body {
  std::string node;
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  double mass = 1, size = 1;  ///< kg, m
  bool turns = true;          ///< false: its rotation is fixed, or it is a point
};

/// A strut between the floor and the frame.
struct Strut {
  std::string name, floor, mount;
  Eigen::Vector3d along = Eigen::Vector3d::Zero();  ///< from the floor to the mount
  double stiffness = 0, length = 0;
  bool on_floor = true;  ///< its lower end is moved, not fixed
};

/// A scene on its way: YAML lines of each block, and what ingredients need to know of each other.
struct Draft {
  explicit Draft(std::uint64_t seed) : draws(seed) {}

  Draws draws;
  bool planar = false, gravity = false;
  std::string title;
  Body frame;
  std::vector<Strut> legs;             ///< with an actuator each
  std::vector<std::string> shakers;    ///< nodes that are prescribed along all axes
  std::vector<std::string> points;     ///< nodes of the frame and of what it carries
  std::vector<std::string> turning;    ///< those that have a rotation
  double frequency_hz = 10;            ///< about where the frame is on its legs
  double damping_ratio = 0;            ///< of struts; other parts have about as much
  bool has_rotor = false;              ///< something turns at a constant rate
  double rate_hz = 0, duration_s = 0;  ///< of a run; 0: the scene has no loop

  std::vector<std::string> nodes, masses, elements, supports, prescribed, dofs, loads, inputs,
      outputs, monitors, comparisons, disturbances, blocks;

  /// The scene as it is written.
  std::string text() const;

  void node(const std::string& name, const Eigen::Vector3d& at);
  /// A point of a body at p, as a node that an arm carries; the body's own node if p is there.
  std::string mount(const Body& body, const std::string& name, const Eigen::Vector3d& p);
  /// A number and a vector as they stand in the scene.
  static std::string number(double value);
  std::string vector(const Eigen::Vector3d& v) const;
};

/// A flexible beam from a node at p with a mass at its end, whose first bending is about omega.
void add_beam(Draft& draft, const std::string& name, const std::string& from,
              const Eigen::Vector3d& p, double length, double tip_mass, double omega);

// The ingredients, in the order in which they are added.

void add_frame(Draft& draft);          ///< a body or a point, guided or free
void add_legs(Draft& draft);           ///< legs, and springs where legs alone do not hold it
void add_mast(Draft& draft);           ///< a flexible beam with a mass at its end
void add_pendulum(Draft& draft);       ///< a body on a hinge with a spring
void add_stage(Draft& draft);          ///< a second mass on springs
void add_rotor(Draft& draft);          ///< a wheel that turns at a constant rate
void add_turning_table(Draft& draft);  ///< in place of a frame: masses on a table that turns
void add_loads(Draft& draft);          ///< gravity has been decided on before
void add_dofs(Draft& draft);
void add_signals(Draft& draft);
void add_controller(Draft& draft);
void add_instruments(Draft& draft);
void add_floor(Draft& draft);
void add_disturbances(Draft& draft);

/// The scene of a seed.
std::string random_scene(std::uint64_t seed);

}  // namespace stillframe::random_scenes
