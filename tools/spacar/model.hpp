#pragma once

#include <Eigen/Core>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/spacar/place.hpp"

namespace stillframe::tools::spacar {

/// A number of the file in a few words: "line 3", "lines 3 and 17".
std::string lines_of(const std::set<int>& lines);

struct Node {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::set<int> lines;
};

enum class Kind { beam, rigid_arm, truss, hinge };

/// An element with what SPACAR says of it: deformations are numbered from 1, stiffness and damping
/// are the numbers of ESTIFF and EDAMP, inertia those of EM.
struct Element {
  Kind kind = Kind::beam;
  std::string name, p, q;
  /// y' of a beam, x' of a hinge; none of what is planar or does not ask for it.
  std::optional<Eigen::Vector3d> direction;
  std::set<int> flexible, prescribed;  ///< DYNE or RLSE; INPUTE
  std::vector<double> stiffness, damping, inertia, stress;
  int n_parts = 1;
  double torsion_factor = 1;  ///< how much stiffer constrained warping makes it
  std::set<int> lines;
};

struct Mass {
  std::string node;
  double mass = 0;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< of a planar model its last entry
  std::set<int> lines;
};

struct Support {
  std::string node;
  std::vector<std::string> fix;
  std::set<int> lines;
};

/// A prescribed coordinate of a node, or deformation of an element.
struct Motion {
  std::string node, along;  ///< or
  std::string element;
  int mode = 0;
  double value = 0, rate = 0, acceleration = 0;  ///< value from the undeformed state
  std::set<int> lines;
};

struct Load {
  std::string node;
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  std::set<int> lines;
};

/// An input or an output: `quantity` and the words around it as a scene has them.
struct Signal {
  std::string name, quantity, of, along;
  int mode = 0;
  std::set<int> lines;
};

/// The model of a SPACAR file in the terms of a scene. Both readers make one.
struct Model {
  std::string title, source;
  std::vector<std::string> given;  ///< what the file has from elsewhere, as it was said
  bool planar = false;
  std::optional<Eigen::Vector3d> gravity;
  std::set<int> gravity_lines;
  double modal_damping = 0;  ///< ratio of each mode
  std::set<int> modal_damping_lines;
  std::vector<Node> nodes;
  std::vector<Element> elements;
  std::vector<Mass> masses;
  std::vector<Support> supports;
  std::vector<Motion> motions;
  std::vector<Load> loads;
  std::vector<Signal> inputs, outputs;
  int n_statements = 0;  ///< how many keywords or fields were read
  Remarks remarks;

  const Node& node(const std::string& name) const;
};

}  // namespace stillframe::tools::spacar
