#include <algorithm>
#include <numbers>

#include "tests/random_scenes/generator/draft.hpp"

// What a frame carries: each with modes of its own, from well below to well above those of the
// frame on its legs.
namespace stillframe::random_scenes {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Whether something that turns can be fastened to the frame.
bool holds_rotation(const Draft& draft) { return !draft.turning.empty(); }

Vector3d somewhere(Draft& draft) {
  return draft.frame.at + draft.frame.size * draft.draws.point(draft.planar);
}

/// Of a body that is as long as wide, about its node.
std::string inertia_text(const Draft& draft, const Matrix3d& J) {
  if (draft.planar) return Draft::number(J(2, 2));
  std::string text = "[";
  for (int i = 0; i < 3; ++i) text += (i ? ", " : "") + draft.vector(J.row(i));
  return text + "]";
}

void add_mass(Draft& draft, const std::string& node, double mass, double radius) {
  const Matrix3d J = Matrix3d::Identity() * (0.4 * mass * radius * radius);
  draft.masses.push_back("{node: " + node + ", mass: " + Draft::number(mass) +
                         (radius > 0 ? ", inertia: " + inertia_text(draft, J) : "") + "}");
}

double omega_of(const Draft& draft, double factor) {
  return 2 * std::numbers::pi * draft.frequency_hz * factor;
}

/// A number with all its digits.
std::string exact(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

/// A direction across another one.
Vector3d across(Draft& draft, const Vector3d& along) {
  for (;;) {
    const Vector3d d = draft.draws.direction(draft.planar);
    if (d.cross(along).norm() > 0.5 * along.norm()) return d;
  }
}

}  // namespace

void add_beam(Draft& draft, const std::string& name, const std::string& from, const Vector3d& p,
              double length, double tip_mass, double omega) {
  Draws& draws = draft.draws;
  const Vector3d along = length * draws.direction(draft.planar);
  const double EI = tip_mass * omega * omega * length * length * length / 3;
  // Radius of gyration of the section, as a part of the length.
  const double slenderness = draws.scale(1e-3, 3e-2);
  const double mass_per_length = tip_mass / length * draws.scale(0.02, 1);
  const bool inextensible = draws.chance(0.2);
  draft.node(name + "_tip", p + along);
  std::string text = name + ": {type: beam, nodes: [" + from + ", " + name + "_tip]";
  if (inextensible) {
    text += ", rigid: [1]";
  } else {
    text += ", EA: " + Draft::number(EI / std::pow(slenderness * length, 2));
  }
  if (draft.planar) {
    text += ", EI: " + Draft::number(EI);
  } else {
    text += ", orientation: " + draft.vector(across(draft, along)) +
            ", GJ: " + Draft::number(0.8 * EI) + ", EI_y: " + Draft::number(EI) +
            ", EI_z: " + Draft::number(EI * draws.between(1, 3)) + ", inertia_per_length: " +
            Draft::number(2 * mass_per_length * std::pow(slenderness * length, 2));
  }
  text += ", mass_per_length: " + Draft::number(mass_per_length);
  if (draft.damping_ratio > 0)
    text += ", damping_time: " + Draft::number(2 * draft.damping_ratio / omega);
  if (draws.chance(0.2)) text += ", second_order: true";
  const int parts = draws.whole(1, 4);
  if (parts > 1) text += ", divide: " + std::to_string(parts);
  draft.elements.push_back(text + "}");
  add_mass(draft, name + "_tip", tip_mass, draws.chance(0.5) ? 0.1 * length : 0);
  draft.points.push_back(name + "_tip");
  draft.turning.push_back(name + "_tip");
  draft.dofs.push_back("{deformations: " + name + "}");
}

void add_mast(Draft& draft) {
  if (!holds_rotation(draft)) return;
  Draws& draws = draft.draws;
  const Vector3d p = somewhere(draft);
  const std::string root = draft.mount(draft.frame, "mast_root", p);
  add_beam(draft, "mast", root, root == "frame" ? draft.frame.at : p,
           draft.frame.size * draws.between(0.5, 2), draft.frame.mass * draws.scale(0.005, 0.2),
           omega_of(draft, draws.scale(1, 15)));
}

void add_pendulum(Draft& draft) {
  if (!holds_rotation(draft)) return;
  Draws& draws = draft.draws;
  const Vector3d p = somewhere(draft);
  const std::string root = draft.mount(draft.frame, "pivot_root", p);
  const Vector3d at = root == "frame" ? draft.frame.at : p;
  const double length = draft.frame.size * draws.between(0.2, 1),
               mass = draft.frame.mass * draws.scale(0.005, 0.2);
  draft.node("pivot", at);
  draft.node("bob", at + length * draws.direction(draft.planar));
  add_mass(draft, "bob", mass, 0.3 * length);
  draft.elements.push_back("rod: {type: rigid_beam, nodes: [pivot, bob]}");
  const double J = 1.04 * mass * length * length;
  // Three times what its weight takes, so that it stays up.
  const double least = draft.gravity ? 3 * mass * 9.81 * length : 0;
  const double stiffness = std::max(J * std::pow(omega_of(draft, draws.scale(0.5, 5)), 2), least);
  const double damping = 2 * draft.damping_ratio * std::sqrt(stiffness * J);
  std::string text = "joint: {type: hinge, nodes: [" + root + ", pivot]";
  const bool ball = !draft.planar && draws.chance(0.3);
  if (!draft.planar) text += ", axis: " + draft.vector(draws.direction(false));
  // Alike across the axis, as a scene says nothing of where the two directions across it are.
  const auto each = [&](double about, double across_axis) {
    return !ball ? Draft::number(about)
                 : "[" + Draft::number(about) + ", " + Draft::number(across_axis) + ", " +
                       Draft::number(across_axis) + "]";
  };
  if (ball) text += ", rigid: []";
  text += ", stiffness: " + each(stiffness, 1.5 * stiffness);
  if (damping > 0) text += ", damping: " + each(damping, 1.5 * damping);
  if (draws.chance(0.2)) text += ", preload: " + each(0.02 * stiffness * draws.between(-1, 1), 0);
  draft.elements.push_back(text + "}");
  draft.points.push_back("bob");
  draft.turning.push_back("bob");
  draft.dofs.push_back("{deformations: joint}");
}

void add_stage(Draft& draft) {
  if (!draft.frame.turns) return;
  Draws& draws = draft.draws;
  const double omega = omega_of(draft, draws.scale(1, 8)),
               mass = draft.frame.mass * draws.scale(0.01, 0.3);
  const Vector3d at = draft.frame.at + 1.5 * draft.frame.size * draws.direction(draft.planar);
  draft.node("stage", at);
  add_mass(draft, "stage", mass, 0);
  const int n = draft.planar ? 2 : 3;
  for (int i = 0; i < n; ++i) {
    // Spread over the three axes, so that they hold it every way.
    const Vector3d spread = Vector3d::Unit(i) + 0.3 * draws.point(draft.planar);
    const std::string name = "stage_" + std::to_string(i + 1);
    const std::string end = draft.mount(draft.frame, "mount_" + name,
                                        at - draft.frame.size * draws.between(0.3, 1) * spread);
    draft.elements.push_back(
        name + ": {type: truss, nodes: [" + end +
        ", stage], stiffness: " + Draft::number(mass * omega * omega * draws.between(0.5, 2)) +
        (draft.damping_ratio > 0
             ? ", damping: " + Draft::number(2 * draft.damping_ratio * mass * omega)
             : "") +
        "}");
  }
  draft.points.push_back("stage");
  const std::vector<std::string> axes = {"x", "y", "z"};
  const bool by_springs = draws.chance(0.5);
  for (int i = 0; i < n; ++i) {
    draft.dofs.push_back(by_springs ? "{element: stage_" + std::to_string(i + 1) + "}"
                                    : "{node: stage, along: " + axes[static_cast<size_t>(i)] + "}");
  }
}

void add_rotor(Draft& draft) {
  if (draft.turning.empty() || !draft.frame.turns) return;
  Draws& draws = draft.draws;
  const Vector3d p = somewhere(draft),
                 axis = draft.planar ? Vector3d::UnitZ() : draws.direction(false);
  const std::string root = draft.mount(draft.frame, "bearing", p);
  draft.node("wheel", root == "frame" ? draft.frame.at : p);
  const double mass = draft.frame.mass * draws.scale(0.01, 0.2), radius = 0.3 * draft.frame.size;
  // Alike about its axis, or its motion would not be stationary. Written with all digits, so that
  // it stays so.
  const double across_axis = mass * radius * radius / 4 * draws.between(1.05, 3),
               about = mass * radius * radius / 2;
  Matrix3d J = across_axis * Matrix3d::Identity() + (about - across_axis) * axis * axis.transpose();
  J = 0.5 * (J + J.transpose()).eval();
  std::string inertia = exact(about), along;
  if (!draft.planar) {
    inertia.clear();
    for (int i = 0; i < 3; ++i) {
      inertia +=
          (i ? ", [" : "[[") + exact(J(i, 0)) + ", " + exact(J(i, 1)) + ", " + exact(J(i, 2)) + "]";
    }
    inertia += "]";
    along = ", axis: [" + exact(axis.x()) + ", " + exact(axis.y()) + ", " + exact(axis.z()) + "]";
  }
  draft.masses.push_back("{node: wheel, mass: " + Draft::number(mass) + ", inertia: " + inertia +
                         "}");
  draft.elements.push_back("spin: {type: hinge, nodes: [" + root + ", wheel]" + along + "}");
  draft.prescribed.push_back(
      "{element: spin, rate: " + Draft::number(draws.scale(0.1, 5) * omega_of(draft, 1)) + "}");
  draft.has_rotor = true;
}

void add_turning_table(Draft& draft) {
  Draws& draws = draft.draws;
  draft.title += ", a turning table";
  const double size = draws.scale(0.1, 2);
  draft.frame.node = "table";
  draft.frame.size = size;
  draft.frame.mass = draws.scale(0.1, 100);
  draft.frequency_hz = draft.gravity ? draws.scale(3, 60) / std::sqrt(size) : draws.scale(1, 60);
  draft.damping_ratio = draws.chance(0.3) ? 0 : draws.between(0, 0.05);
  if (draft.planar) draft.gravity = false;  // it would turn, as the table sees it
  draft.node("ground", Vector3d::Zero());
  draft.node("table", Vector3d::Zero());
  draft.supports.push_back(draft.planar ? "{nodes: [ground], fix: [x, y, rotation]}"
                                        : "{nodes: [ground], fix: [x, y, z, rotation]}");
  draft.elements.push_back(draft.planar ? "axle: {type: hinge, nodes: [ground, table]}"
                                        : "axle: {type: hinge, nodes: [ground, table], axis: z}");
  // Well below its lowest frequency, where it would fly apart.
  draft.prescribed.push_back(
      "{element: axle, rate: " + Draft::number(omega_of(draft, draws.between(0.02, 0.3))) + "}");
  draft.frame.turns = true;
  const double omega = omega_of(draft, 1), mass = draft.frame.mass;
  const Vector3d at = size * draws.point(draft.planar);
  draft.node("rider", at);
  add_mass(draft, "rider", mass, 0);
  draft.points.push_back("rider");
  for (int i = 0; i < (draft.planar ? 2 : 3); ++i) {
    const std::string name = "spring_" + std::to_string(i + 1);
    const Vector3d end =
        at - size * draws.between(0.5, 1) * (Vector3d::Unit(i) + 0.3 * draws.point(draft.planar));
    const std::string mount = draft.mount(draft.frame, "post_" + std::to_string(i + 1), end);
    const double stiffness = mass * omega * omega * draws.between(0.8, 2);
    draft.elements.push_back(
        name + ": {type: truss, nodes: [" + mount +
        ", rider], stiffness: " + Draft::number(stiffness) +
        (draft.damping_ratio > 0
             ? ", damping: " + Draft::number(2 * draft.damping_ratio * stiffness / omega)
             : "") +
        "}");
    draft.dofs.push_back("{element: " + name + "}");
  }
  if (draws.chance(0.4)) {
    const Vector3d p = size * draws.point(draft.planar);
    const std::string root = draft.mount(draft.frame, "blade_root", p);
    add_beam(draft, "blade", root, root == "table" ? Vector3d(Vector3d::Zero()) : p,
             size * draws.between(0.5, 1.5), draft.frame.mass * draws.scale(0.05, 1),
             omega_of(draft, draws.between(1.2, 4)));
  }
  draft.has_rotor = true;
}

}  // namespace stillframe::random_scenes
