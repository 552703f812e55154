#include "core/mechanics/scene/nodes_masses.hpp"

#include <Eigen/Eigenvalues>

#include "core/mechanics/scene/references.hpp"

namespace stillframe {

namespace {

/// Three principal moments about the global axes, or the whole matrix.
Eigen::Matrix3d read_spatial_inertia(const YamlReader& value) {
  Eigen::Matrix3d inertia;
  const auto items = value.items();
  if (!items.empty() && items.front().is_sequence()) {
    inertia = value.matrix(3, 3);
  } else {
    inertia = value.vector(3).asDiagonal();
  }
  if ((inertia - inertia.transpose()).cwiseAbs().maxCoeff() > 0) {
    value.fail("the inertia matrix is not symmetric");
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
  const Eigen::Vector3d moments = solver.eigenvalues();  // ascending
  if (!(moments(0) >= 0)) value.fail("the inertia matrix has a negative principal moment");
  // A body's largest principal moment never exceeds the sum of the others; 1e-12 is rounding.
  if (!(moments(2) <= (moments(0) + moments(1)) * (1 + 1e-12))) {
    value.fail("no body has these principal moments: the largest exceeds the sum of the other two");
  }
  return inertia;
}

Eigen::Matrix3d read_planar_inertia(const YamlReader& value) {
  if (!value.is_scalar()) {
    value.fail("allowed in a planar scene is one number, the moment of inertia about z");
  }
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  inertia(2, 2) = value.non_negative();
  return inertia;
}

SceneMass read_mass(const YamlReader& value, const Scene& scene) {
  value.allow_only({"node", "mass", "inertia"});
  SceneMass mass;
  mass.place = value.place();
  mass.node = read_node_name(value.require("node"), scene).name;
  mass.mass = value.require("mass").non_negative();
  mass.inertia.setZero();
  if (const auto inertia = value.find("inertia")) {
    mass.inertia = scene.planar ? read_planar_inertia(*inertia) : read_spatial_inertia(*inertia);
    mass.has_inertia = true;
  }
  return mass;
}

}  // namespace

void read_nodes(const YamlReader& map, Scene& scene) {
  for (const auto& [name, value] : map.entries()) {
    refuse_slash(value, name);
    value.allow_only({"position"});
    scene.nodes.push_back({name, value.place(), read_vector(value.require("position"), scene)});
  }
}

void read_masses(const YamlReader& list, Scene& scene) {
  for (const YamlReader& value : list.items()) scene.masses.push_back(read_mass(value, scene));
}

}  // namespace stillframe
