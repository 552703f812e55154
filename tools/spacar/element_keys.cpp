#include "tools/spacar/element_keys.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/yaml/reader.hpp"

namespace stillframe::tools::spacar {

namespace {

/// The stiffness of what SPACAR leaves without: the least number that a beam of a scene takes. Over
/// any length that is nothing beside a newton.
constexpr double no_stiffness = smallest_number;

double at(const std::vector<double>& numbers, std::size_t i) {
  return i < numbers.size() ? numbers[i] : 0;
}

std::string number_list(const std::vector<int>& numbers) {
  std::string text;
  for (const int number : numbers) {
    if (!text.empty()) text += ", ";
    text += std::to_string(number);
  }
  return '[' + text + ']';
}

std::vector<int> rigid_modes(const Element& element, int n) {
  std::vector<int> rigid;
  for (int mode = 1; mode <= n; ++mode) {
    if (!element.flexible.contains(mode)) rigid.push_back(mode);
  }
  return rigid;
}

void note_stress_of_rigid(Model& model, const Element& element) {
  for (std::size_t i = 0; i < element.stress.size(); ++i) {
    const int mode = static_cast<int>(i) + 1;
    if (element.stress[i] == 0 || element.flexible.contains(mode)) continue;
    model.remarks.left_out.push_back({.line = *element.lines.begin(),
                                      .what = "ESIG of " + element.name,
                                      .why = "deformation " + std::to_string(mode) +
                                             " is rigid, and has the stress that holds it"});
  }
}

/// ESIG where an element bends; what is rigid finds its stress itself.
std::vector<double> preload_of(Model& model, const Element& element, int n) {
  note_stress_of_rigid(model, element);
  std::vector<double> preload;
  for (int mode = 1; mode <= n; ++mode) {
    preload.push_back(element.flexible.contains(mode)
                          ? at(element.stress, static_cast<std::size_t>(mode - 1))
                          : 0);
  }
  const bool any = std::any_of(preload.begin(), preload.end(), [](double s) { return s != 0; });
  return any ? preload : std::vector<double>{};
}

double length_of(const Model& model, const Element& element) {
  return (model.node(element.q).position - model.node(element.p).position).norm();
}

/// x', y' and z' of a beam as columns.
Eigen::Matrix3d axes_of(const Model& model, const Element& element) {
  const Eigen::Vector3d n_x =
      (model.node(element.q).position - model.node(element.p).position).normalized();
  if (model.planar) {
    Eigen::Matrix3d R;
    R << n_x, Eigen::Vector3d(-n_x.y(), n_x.x(), 0), Eigen::Vector3d::UnitZ();
    return R;
  }
  const Eigen::Vector3d towards = element.direction.value_or(n_x.unitOrthogonal());
  const Eigen::Vector3d n_y = (towards - towards.dot(n_x) * n_x).normalized();
  Eigen::Matrix3d R;
  R << n_x, n_y, n_x.cross(n_y);
  return R;
}

/// EDAMP: as the stiffness of a beam that does not shear, d_1 / l and so on.
Eigen::MatrixXd beam_damping(const Model& model, const Element& element) {
  const double l = length_of(model, element), cubed = l * l * l;
  const int n = model.planar ? 3 : 6, first_bending = model.planar ? 1 : 2;
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(n, n);
  D(0, 0) = at(element.damping, 0) / l;
  if (!model.planar) D(1, 1) = at(element.damping, 1) / cubed;
  for (int i = first_bending, k = first_bending; i < n; i += 2, ++k) {
    const double d = at(element.damping, static_cast<std::size_t>(k)) / cubed;
    D.block<2, 2>(i, i) << 4 * d, -2 * d, -2 * d, 4 * d;
  }
  for (const int mode : rigid_modes(element, n)) {
    D.row(mode - 1).setZero();
    D.col(mode - 1).setZero();
  }
  return D;
}

/// Rotary inertia at both ends of each part, half of it each: a beam of a scene has that of its
/// torsion alone. `per_length` about x', y' and z'.
void add_rotary(const Model& model, const Element& element, const Eigen::Vector3d& per_length,
                std::vector<Mass>& masses) {
  if (per_length.isZero(0)) return;
  const Eigen::Matrix3d R = axes_of(model, element);
  const double half = length_of(model, element) / element.n_parts / 2;
  Eigen::Matrix3d J = R * (half * per_length).asDiagonal() * R.transpose();
  J = ((J + J.transpose()) / 2).eval();
  for (int i = 0; i <= element.n_parts; ++i) {
    const bool is_end = i == 0 || i == element.n_parts;
    std::string node = i == 0 ? element.p : element.q;
    if (!is_end) {
      node = element.name + '/';
      node += std::to_string(i);
    }
    masses.push_back({.node = node, .inertia = is_end ? J : 2 * J, .lines = element.lines});
  }
}

void add_section(Keys& keys, const Model& model, const Element& element) {
  const auto any = [&](int a, int b) {
    return element.flexible.contains(a) || element.flexible.contains(b);
  };
  const auto add = [&](const char* key, bool needed, std::size_t i, double factor) {
    if (!needed) return;
    const double value = at(element.stiffness, i) * factor;
    keys.emplace_back(key, shortest_digits(value > 0 ? value : no_stiffness));
  };
  const auto add_shear = [&](const char* key, bool needed, std::size_t i, std::size_t over) {
    const double area = at(element.stiffness, over);
    if (!needed || area == 0 || at(element.stiffness, i) == 0) return;
    keys.emplace_back(key, shortest_digits(at(element.stiffness, i) / area));
  };
  const auto both = [&](int a, int b) {
    return element.flexible.contains(a) && element.flexible.contains(b);
  };
  add("EA", any(1, 1), 0, 1);
  if (model.planar) {
    add("EI", any(2, 3), 1, 1);
    add_shear("shear", both(2, 3), 1, 2);
    return;
  }
  add("GJ", any(2, 2), 1, element.torsion_factor);
  add("EI_y", any(3, 4), 2, 1);
  add("EI_z", any(5, 6), 3, 1);
  add_shear("shear_y", both(5, 6), 3, 5);
  add_shear("shear_z", both(3, 4), 2, 4);
}

void note_shear_of_half_rigid(Model& model, const Element& element) {
  const auto half = [&](int a, int b, std::size_t i) {
    return element.flexible.contains(a) != element.flexible.contains(b) &&
           at(element.stiffness, i) > 0;
  };
  const bool left = model.planar ? half(2, 3, 2) : half(3, 4, 4) || half(5, 6, 5);
  if (!left) return;
  model.remarks.approximated.push_back(
      {.line = *element.lines.begin(),
       .what = "shear of " + element.name,
       .why = "left out where one of the two bending deformations is rigid"});
}

Keys beam_keys(Model& model, const Element& element, std::vector<Mass>& masses) {
  const int n = model.planar ? 3 : 6;
  const bool rigid = element.flexible.empty();
  const double mass = at(element.inertia, 0);
  Eigen::Vector3d rotary = Eigen::Vector3d::Zero();  // about x', y' and z', per length
  if (model.planar) {
    rotary.z() = at(element.inertia, 1);
  } else {
    rotary = {at(element.inertia, 1), at(element.inertia, 2), at(element.inertia, 3)};
  }
  if (!model.planar && at(element.inertia, 4) != 0) {
    model.remarks.left_out.push_back({.line = *element.lines.begin(),
                                      .what = "EM of " + element.name,
                                      .why = "its fifth number, the product of inertia of y' and "
                                             "z', is not in the scene"});
  }
  const std::string nodes = '[' + element.p + ", " + element.q + ']';
  if (rigid && mass == 0) {
    add_rotary(model, element, rotary, masses);
    return {{"type", "rigid_beam"}, {"nodes", nodes}};
  }
  Keys keys{{"type", "beam"}, {"nodes", nodes}};
  if (!model.planar) {
    const Eigen::Vector3d y = element.direction.value_or(axes_of(model, element).col(1));
    keys.emplace_back("orientation", list_of({y.x(), y.y(), y.z()}));
  }
  add_section(keys, model, element);
  note_shear_of_half_rigid(model, element);
  if (mass > 0) keys.emplace_back("mass_per_length", shortest_digits(mass));
  // A moment of inertia is at most the sum of the other two, at a node as anywhere: what the
  // difference of the two across the beam needs about its axis is taken from the beam.
  const double at_nodes = std::min(std::abs(rotary.y() - rotary.z()), rotary.x());
  if (!model.planar && !rigid && rotary.x() - at_nodes > smallest_number) {
    keys.emplace_back("inertia_per_length", shortest_digits(rotary.x() - at_nodes));
    rotary.x() = at_nodes;
  }
  add_rotary(model, element, rotary, masses);
  if (!element.damping.empty() && !rigid) {
    keys.emplace_back("damping", matrix_of(beam_damping(model, element)));
  }
  const std::vector<double> preload = preload_of(model, element, n);
  if (!preload.empty()) keys.emplace_back("preload", list_of(preload));
  const std::vector<int> held = rigid_modes(element, n);
  if (rigid) {
    keys.emplace_back("rigid", "true");
  } else {
    if (!held.empty()) keys.emplace_back("rigid", number_list(held));
    keys.emplace_back("second_order", "true");
  }
  if (element.n_parts > 1) keys.emplace_back("divide", std::to_string(element.n_parts));
  return keys;
}

Keys truss_keys(Model& model, const Element& element, std::vector<Mass>& masses) {
  Keys keys{{"type", "truss"}, {"nodes", '[' + element.p + ", " + element.q + ']'}};
  const double l = length_of(model, element), mass = at(element.inertia, 0);
  if (mass > 0) {
    for (const std::string& node : {element.p, element.q}) {
      masses.push_back({.node = node, .mass = mass * l / 2, .lines = element.lines});
    }
    model.remarks.approximated.push_back({.line = *element.lines.begin(),
                                          .what = "EM of " + element.name,
                                          .why = "half of what the truss weighs is at each end"});
  }
  if (element.flexible.empty()) {
    note_stress_of_rigid(model, element);
    keys.emplace_back("rigid", "true");
    return keys;
  }
  keys.emplace_back("stiffness", shortest_digits(at(element.stiffness, 0) / l));
  if (at(element.damping, 0) != 0) {
    keys.emplace_back("damping", shortest_digits(at(element.damping, 0) / l));
  }
  if (at(element.stress, 0) != 0) keys.emplace_back("preload", shortest_digits(element.stress[0]));
  return keys;
}

Keys hinge_keys(Model& model, const Element& element) {
  Keys keys{{"type", "hinge"}, {"nodes", '[' + element.p + ", " + element.q + ']'}};
  const int n = model.planar ? 1 : 3;
  if (element.direction) {
    keys.emplace_back(
        "axis", list_of({element.direction->x(), element.direction->y(), element.direction->z()}));
  }
  const std::vector<int> held = rigid_modes(element, n);
  if (static_cast<int>(held.size()) == n) {
    keys.emplace_back("rigid", "true");
  } else if (!model.planar) {
    keys.emplace_back("rigid", number_list(held));
  }
  const auto per_mode = [&](const char* key, const std::vector<double>& numbers) {
    std::vector<double> values;
    for (int mode = 1; mode <= n; ++mode) {
      values.push_back(
          element.flexible.contains(mode) ? at(numbers, static_cast<std::size_t>(mode - 1)) : 0);
    }
    if (std::all_of(values.begin(), values.end(), [](double v) { return v == 0; })) return;
    keys.emplace_back(key, n == 1 ? shortest_digits(values[0]) : list_of(values));
  };
  per_mode("stiffness", element.stiffness);
  per_mode("damping", element.damping);
  note_stress_of_rigid(model, element);
  per_mode("preload", element.stress);
  return keys;
}

}  // namespace

std::string list_of(const std::vector<double>& numbers) {
  std::string text;
  for (const double number : numbers) {
    if (!text.empty()) text += ", ";
    text += shortest_digits(number == 0 ? 0 : number);
  }
  return '[' + text + ']';
}

std::string matrix_of(const Eigen::MatrixXd& matrix) {
  std::string text;
  for (const auto& row : matrix.rowwise()) {
    if (!text.empty()) text += ", ";
    text += list_of({row.begin(), row.end()});
  }
  return '[' + text + ']';
}

Keys element_keys(Model& model, const Element& element, std::vector<Mass>& masses) {
  switch (element.kind) {
    case Kind::beam:
      return beam_keys(model, element, masses);
    case Kind::truss:
      return truss_keys(model, element, masses);
    case Kind::hinge:
      return hinge_keys(model, element);
    case Kind::rigid_arm:
      break;
  }
  return {{"type", "rigid_beam"}, {"nodes", '[' + element.p + ", " + element.q + ']'}};
}

}  // namespace stillframe::tools::spacar
