#include "core/control/robustness/parameters.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/control/design/control_loop.hpp"
#include "core/errors/formatted.hpp"
#include "core/mechanics/model/model.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/alter.hpp"
#include "core/mechanics/state_space.hpp"

namespace stillframe::robustness {

using Eigen::Vector3d;
using Kind = Parameter::Kind;

namespace {

bool ends_a_leg(const Scene& scene, const std::string& node) {
  const auto& legs = scene.controller->legs;
  return std::any_of(legs.begin(), legs.end(), [&](const std::string& leg) {
    const SceneElement& element = scene.elements[element_index(scene, leg)];
    return element.node_p == node || element.node_q == node;
  });
}

using List = std::vector<Parameter>;

void add_legs(const Scene& scene, Kind kind, double size, List& list) {
  if (size == 0) return;
  const auto& legs = scene.controller->legs;
  for (size_t i = 0; i < legs.size(); ++i) list.push_back({kind, legs[i], i, {}, size});
}

void add_dampings(const Scene& scene, double size, List& list) {
  if (size == 0) return;
  const auto& legs = scene.controller->legs;
  for (size_t i = 0; i < legs.size(); ++i) {
    if (!is_damped(scene.elements[element_index(scene, legs[i])])) continue;
    list.push_back({Kind::damping, legs[i], i, {}, size});
  }
}

void add_masses(const Scene& scene, const SceneUncertainty& uncertainty, List& list) {
  for (size_t i = 0; i < scene.masses.size() && uncertainty.mass > 0; ++i) {
    if (scene.masses[i].mass == 0) continue;
    list.push_back({Kind::mass, scene.masses[i].node, i, {}, uncertainty.mass});
  }
  for (size_t i = 0; i < scene.masses.size() && uncertainty.inertia > 0; ++i) {
    if (!scene.masses[i].has_inertia) continue;
    list.push_back({Kind::inertia, scene.masses[i].node, i, {}, uncertainty.inertia});
  }
}

void add_centres(const Scene& scene, double size, List& list) {
  if (size == 0) return;
  const int n_axes = scene.planar ? 2 : 3;
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const std::string& node = scene.nodes[i].name;
    const bool carries =
        std::any_of(scene.masses.begin(), scene.masses.end(),
                    [&](const SceneMass& mass) { return mass.node == node && mass.mass > 0; });
    if (!carries || ends_a_leg(scene, node) ||
        directions_held(scene, node) >= static_cast<size_t>(n_axes)) {
      continue;
    }
    for (int axis = 0; axis < n_axes; ++axis) {
      list.push_back({Kind::centre_of_mass, node, i, Vector3d::Unit(axis), size});
    }
  }
}

void add_directions(const Scene& scene, double size, List& list) {
  if (size == 0) return;
  const auto& legs = scene.controller->legs;
  for (size_t i = 0; i < legs.size(); ++i) {
    const Vector3d span = leg_of(scene, legs[i]).span;
    if (span.isZero(0)) continue;  // a hinge has no direction to turn
    for (const Vector3d& direction : across(span, scene.planar)) {
      list.push_back({Kind::leg_direction, legs[i], i, direction, size});
    }
  }
}

}  // namespace

std::vector<Parameter> parameters_of(const Scene& scene, const SceneUncertainty& uncertainty) {
  List list;
  add_legs(scene, Kind::stiffness, uncertainty.stiffness, list);
  add_dampings(scene, uncertainty.damping, list);
  add_masses(scene, uncertainty, list);
  add_centres(scene, uncertainty.centre_of_mass_m, list);
  add_directions(scene, uncertainty.leg_direction_rad, list);
  add_legs(scene, Kind::actuator_gain, uncertainty.actuator_gain, list);
  add_legs(scene, Kind::sensor_gain, uncertainty.sensor_gain, list);
  if (uncertainty.delay_samples > 0) {
    list.push_back({Kind::delay, "", 0, {}, uncertainty.delay_samples});
  }
  return list;
}

namespace {

std::string direction_text(const Vector3d& direction) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(direction(axis) - 1) < 1e-12) return {"xyz"[axis]};
  }
  const auto part = [&](int axis) {  // without the sign of a zero
    return formatted("%.3g", std::abs(direction(axis)) < 1e-12 ? 0.0 : direction(axis));
  };
  std::string out = "(";
  for (int axis = 0; axis < 3; ++axis) out += part(axis) + (axis < 2 ? ", " : ")");
  return out;
}

}  // namespace

namespace {

/// How people and how scenes call a kind.
struct KindName {
  Kind kind;
  const char *text, *key;
};
constexpr KindName kind_names[] = {
    {Kind::stiffness, "stiffness", "stiffness"},
    {Kind::damping, "damping", "damping"},
    {Kind::mass, "mass", "mass"},
    {Kind::inertia, "inertia", "inertia"},
    {Kind::centre_of_mass, "centre of mass", "centre_of_mass_m"},
    {Kind::leg_direction, "foot", "leg_direction_rad"},
    {Kind::actuator_gain, "actuator gain", "actuator_gain"},
    {Kind::sensor_gain, "sensor gain", "sensor_gain"},
    {Kind::delay, "delay", "delay_samples"},
};

const KindName& names_of(Kind kind) {
  return *std::ranges::find(kind_names, kind, &KindName::kind);
}

}  // namespace

std::string kind_text(Kind kind) { return names_of(kind).text; }

std::string key_of(Kind kind) { return names_of(kind).key; }

std::string subject_text(const Parameter& parameter) {
  switch (parameter.kind) {
    case Kind::centre_of_mass:
      return parameter.subject + " along " + direction_text(parameter.direction);
    case Kind::leg_direction:
      return parameter.subject + " towards " + direction_text(parameter.direction);
    default:
      return parameter.subject;
  }
}

std::string deviation_text(const Parameter& parameter, double value) {
  const double deviation = value * parameter.size;
  switch (parameter.kind) {
    case Kind::centre_of_mass:
      return formatted("%+.4g mm", 1e3 * deviation);
    case Kind::leg_direction:
      return formatted("%+.4g mrad", 1e3 * deviation);
    case Kind::delay:
      return formatted("%+.4g samples", deviation);
    default:
      return formatted("%+.4g %%", 100 * deviation);
  }
}

std::string name_of(const Parameter& parameter) {
  if (parameter.kind == Kind::delay) return kind_text(parameter.kind);
  const std::string suffix = subject_text(parameter).substr(parameter.subject.size());
  return parameter.subject + " " + kind_text(parameter.kind) + suffix;
}

std::string describe(const Parameter& parameter, double value) {
  return name_of(parameter) + " " + deviation_text(parameter, value);
}

namespace {

/// Everything but the directions of the legs.
void apply(const Parameter& parameter, double deviation, PerturbedPlant& plant) {
  const auto index = static_cast<Eigen::Index>(parameter.index);
  switch (parameter.kind) {
    case Kind::stiffness:
      scale_stiffness(plant.scene.elements[element_index(plant.scene, parameter.subject)],
                      1 + deviation);
      break;
    case Kind::damping:
      scale_damping(plant.scene.elements[element_index(plant.scene, parameter.subject)],
                    1 + deviation);
      break;
    case Kind::mass:
      plant.scene.masses[parameter.index].mass *= 1 + deviation;
      break;
    case Kind::inertia:
      plant.scene.masses[parameter.index].inertia *= 1 + deviation;
      break;
    case Kind::centre_of_mass:
      move_node(plant.scene, parameter.index, deviation * parameter.direction);
      break;
    case Kind::leg_direction:
      break;
    case Kind::actuator_gain:
      plant.sampling.leg_gains(index) *= 1 + deviation;
      break;
    case Kind::sensor_gain:
      plant.sampling.sensor_gains(index) *= 1 + deviation;
      break;
    case Kind::delay:
      plant.sampling.delay_samples = std::max(0.0, plant.sampling.delay_samples + deviation);
      break;
  }
}

}  // namespace

PerturbedPlant perturbed(const Scene& scene, const Sampling& sampling,
                         const std::vector<Parameter>& parameters, const Eigen::VectorXd& values) {
  if (values.size() != static_cast<Eigen::Index>(parameters.size())) {
    throw std::invalid_argument("perturbed: expected " + std::to_string(parameters.size()) +
                                " values, got " + std::to_string(values.size()));
  }
  PerturbedPlant plant{scene, sampling};
  const auto& legs = scene.controller->legs;
  for (Eigen::VectorXd* gains : {&plant.sampling.leg_gains, &plant.sampling.sensor_gains}) {
    if (gains->size() == 0) gains->setOnes(static_cast<Eigen::Index>(legs.size()));
  }
  std::vector<Vector3d> angles(legs.size(), Vector3d::Zero());
  for (size_t i = 0; i < parameters.size(); ++i) {
    const double deviation = parameters[i].size * values(static_cast<Eigen::Index>(i));
    apply(parameters[i], deviation, plant);
    if (parameters[i].kind == Kind::leg_direction) {
      angles[parameters[i].index] += deviation * parameters[i].direction;
    }
  }
  for (size_t i = 0; i < legs.size(); ++i) turn_leg(plant.scene, leg_of(scene, legs[i]), angles[i]);
  return plant;
}

SampledPlant sampled(const PerturbedPlant& plant) {
  const auto n_w = static_cast<Eigen::Index>(plant.scene.inputs.size());
  const auto n_y = static_cast<Eigen::Index>(plant.scene.outputs.size());
  const LinearModel model = loop_model(plant.scene, model_of(plant.scene));
  return sample_and_hold(loop_plant(model, n_w, n_y), plant.sampling);
}

}  // namespace stillframe::robustness
