// The elements, dofs, inertias and loads of a model, and the whole.
#include <algorithm>
#include <stdexcept>

#include "core/errors/input_error.hpp"
#include "core/mechanics/elements/arm_truss.hpp"
#include "core/mechanics/elements/beam.hpp"
#include "core/mechanics/elements/hinge.hpp"
#include "core/mechanics/elements/norm_condition.hpp"
#include "core/mechanics/elements/planar_beam.hpp"
#include "core/mechanics/elements/planar_hinge.hpp"
#include "core/mechanics/elements/second_order.hpp"
#include "core/mechanics/elements/superelement.hpp"
#include "core/mechanics/elements/truss.hpp"
#include "core/mechanics/inertia/beam_mass.hpp"
#include "core/mechanics/inertia/body.hpp"
#include "core/mechanics/inertia/lumped.hpp"
#include "core/mechanics/inertia/planar_beam_mass.hpp"
#include "core/mechanics/inertia/superelement_mass.hpp"
#include "core/mechanics/modal_damping.hpp"
#include "core/mechanics/model/builder.hpp"
#include "core/mechanics/model/section.hpp"
#include "core/mechanics/partition/automatic_dofs.hpp"
#include "core/mechanics/partition/memory.hpp"
#include "core/mechanics/partition/partition.hpp"

namespace stillframe {

namespace {

using Kind = SceneElement::Kind;

bool is_beam(const SceneElement& element) {
  return element.kind == Kind::beam || element.kind == Kind::rigid_beam;
}

/// The deformation functions of a scene's element.
std::unique_ptr<const Element> make_element(const SceneElement& element, Index p, Index q,
                                            const Eigen::Vector3d& l_0, bool planar) {
  switch (element.kind) {
    case Kind::truss:
      if (!element.arm_p.isZero(0) || !element.arm_q.isZero(0)) {
        return std::make_unique<ArmTruss>(p, q, l_0, element.arm_p, element.arm_q);
      }
      return std::make_unique<Truss>(p, q, l_0);
    case Kind::hinge:
      if (planar) return std::make_unique<PlanarHinge>(p, q);
      return std::make_unique<Hinge>(p, q, element.axis);
    case Kind::beam:
    case Kind::rigid_beam:
    case Kind::superelement:
      break;
  }
  std::unique_ptr<const Element> beam;
  if (planar) {
    beam = std::make_unique<PlanarBeam>(p, q, l_0);
  } else {
    const bool free = element.kind == Kind::rigid_beam;
    beam =
        std::make_unique<Beam>(p, q, l_0, free ? any_orientation(l_0) : element.beam.orientation);
  }
  if (!element.beam.second_order) return beam;
  const double length = l_0.norm();
  // Deflection along n_z bends about n_y.
  const double Phi_y = shear_ratio_z(element.beam, length),
               Phi_z = shear_ratio_y(element.beam, length);
  return std::make_unique<SecondOrder>(std::move(beam),
                                       planar ? planar_second_order_terms(length, Phi_z)
                                              : spatial_second_order_terms(length, Phi_y, Phi_z));
}

}  // namespace

Model ModelBuilder::build() {
  model_.title = scene_.title;
  model_.planar = scene_.planar;
  model_.gravity = scene_.gravity;
  model_.operating_point = scene_.operating_point;
  for (const SceneNode& node : scene_.nodes) {
    model_.nodes.push_back({node.name, node.position, {}, {}});
  }
  share_translations();
  plan_rotations();
  claim_directions();
  number_coordinates();
  place_elements();
  number_deformations();
  resolve_dofs();
  place_inertias();
  place_loads();
  place_operating_point();
  return std::move(model_);
}

template <class Part>
std::vector<PartMap> ModelBuilder::maps_of(const Part& part) const {
  std::vector<PartMap> maps;
  for (const NodePart& p : part.parts()) {
    const ModelNode& node = model_.nodes[static_cast<size_t>(p.node)];
    maps.push_back(p.kind == NodePart::Kind::translation ? node.translation : node.rotation);
  }
  return maps;
}

void ModelBuilder::place_elements() {
  for (size_t n = 0; n < plans_.size(); ++n) {
    if (plans_[n].rotation_size == 4 && plans_[n].rotation_kind[0] != CoordinateKind::fixed) {
      add_element(model_.nodes[n].name + " (norm)",
                  std::make_unique<NormCondition>(static_cast<Index>(n)));
      model_.elements.back().zero[0] = true;
    }
  }
  for (const SceneElement& element : scene_.elements) place_element(element);
}

Superelement ModelBuilder::superelement(const SceneSuperelement& body) const {
  const auto indices = [&](const std::vector<std::string>& names) {
    std::vector<Index> nodes;
    for (const std::string& name : names) nodes.push_back(node_index_.at(name));
    return nodes;
  };
  return Superelement(indices(body.nodes), body.s, indices(body.mode_nodes), body.n_modes);
}

void ModelBuilder::place_element(const SceneElement& element) {
  if (element.superelement) {
    add_element(element.name, std::make_unique<Superelement>(superelement(*element.superelement)));
    ModelElement& item = model_.elements.back();
    item.S = element.stiffness;
    item.S_d = element.damping;
    item.damped = !item.S_d.isZero(0);
    return;
  }
  const Index p = node_index_.at(element.node_p), q = node_index_.at(element.node_q);
  const Eigen::Vector3d l_0 = model_.nodes[static_cast<size_t>(q)].position + element.arm_q -
                              model_.nodes[static_cast<size_t>(p)].position - element.arm_p;
  try {
    add_element(element.name, make_element(element, p, q, l_0, scene_.planar));
  } catch (const std::invalid_argument& error) {
    throw InputError(element.place + ": '" + element.name + "': " + error.what());
  }
  ModelElement& item = model_.elements.back();
  const Index n_e = item.element->n_deformations();
  for (Index i = 0; i < n_e; ++i)
    item.zero[static_cast<size_t>(i)] = element.zero[static_cast<size_t>(i)];
  if (element.rigid()) return;
  item.S = element.stiffness;
  item.S_d = element.damping;
  if (element.kind == Kind::beam) {
    const LocalStiffness section = section_stiffness(element.beam, l_0.norm(), scene_.planar);
    item.S += section;
    item.S_d += element.beam.damping_time * section;
  }
  item.damped = !item.S_d.isZero(0);
}

void ModelBuilder::add_element(const std::string& name, std::unique_ptr<const Element> element) {
  ModelElement item;
  item.name = name;
  item.parts = maps_of(*element);
  item.row.assign(static_cast<size_t>(element->n_deformations()), 0);
  item.zero.assign(item.row.size(), false);
  item.element = std::move(element);
  model_.elements.push_back(std::move(item));
}

/// Rows: conditions first (zero, dynamic and prescribed deformations in the order of the elements),
/// redundant ones last.
void ModelBuilder::number_deformations() {
  std::map<std::pair<std::string, int>, Index> dof_of, prescribed;
  for (size_t i = 0; i < scene_.dofs.size(); ++i) {
    const SceneDof& dof = scene_.dofs[i];
    if (dof.element.empty()) continue;
    if (!dof_of.emplace(std::pair(dof.element, dof.mode), static_cast<Index>(i)).second) {
      throw InputError(dof.place + ": this dof is named twice");
    }
  }
  for (const SceneConstraint& motion : scene_.prescribed) {
    if (motion.element.empty()) continue;
    const std::pair key(motion.element, motion.mode);
    if (dof_of.contains(key) ||
        !prescribed.emplace(key, static_cast<Index>(prescribed.size())).second) {
      throw InputError(motion.place + ": this deformation is prescribed twice, or a dof as well");
    }
  }
  model_.prescribed_rows.assign(prescribed.size(), -1);
  model_.n_r = model_.n_rx + static_cast<Index>(prescribed.size());
  Index row = 0;
  for (const bool conditions : {true, false}) {
    const Index first = row;
    for (ModelElement& item : model_.elements) {
      for (Index i = 0; i < item.element->n_deformations(); ++i) {
        const std::pair key(item.name, static_cast<int>(i + 1));
        const auto dof = dof_of.find(key), motion = prescribed.find(key);
        const bool zero = item.zero[static_cast<size_t>(i)];
        if (zero && dof != dof_of.end()) {
          throw InputError(scene_.dofs[static_cast<size_t>(dof->second)].place + ": '" + item.name +
                           "' is rigid, its deformation can be no dof");
        }
        const bool condition = zero || dof != dof_of.end() || motion != prescribed.end();
        if (condition != conditions) continue;
        if (conditions) model_.conditions.emplace_back();
        if (dof != dof_of.end()) {
          dof_index_[static_cast<size_t>(dof->second)] = row;
          model_.conditions.back().dof = dof->second;
        }
        if (motion != prescribed.end()) {
          model_.prescribed_rows[static_cast<size_t>(motion->second)] = row;
          model_.conditions.back().prescribed = motion->second;
        }
        item.row[static_cast<size_t>(i)] = row++;
      }
    }
    if (!conditions) model_.n_redundant = row - first;
  }
  model_.n_e = row;
  model_.preload = Eigen::VectorXd::Zero(row);
  size_t k = model_.elements.size() - scene_.elements.size();  // behind the norms, in their order
  for (const SceneElement& element : scene_.elements) {
    const ModelElement& item = model_.elements[k++];
    if (element.rigid()) continue;
    for (Index i = 0; i < item.element->n_deformations(); ++i) {
      model_.preload(item.row[static_cast<size_t>(i)]) = element.preload(i);
    }
  }
}

std::string ModelBuilder::dof_name(const SceneDof& dof, size_t i) const {
  if (!dof.element.empty()) {
    const auto& item = model_.elements[static_cast<size_t>(model_.element_index(dof.element))];
    const bool alone = item.element->n_deformations() == 1;
    return (alone ? "e(" : "e_" + std::to_string(dof.mode) + "(") + dof.element + ")";
  }
  return coordinate_name(dof, i);
}

std::string coordinate_name(const SceneDof& dof, size_t i) {
  if (dof.rotation) return "phi(" + dof.node + ")";
  if (!dof.direction) {
    return "lambda_" + std::to_string(dof.euler_parameter) + "(" + dof.node + ")";
  }
  for (int axis = 0; axis < 3; ++axis) {
    if ((*dof.direction)(axis) == 1.0) return std::string(1, "xyz"[axis]) + "(" + dof.node + ")";
  }
  return "x(" + dof.node + ")" + std::to_string(i + 1);
}

std::string coordinate_unit(const SceneDof& dof) {
  return dof.rotation ? "rad" : dof.euler_parameter >= 0 ? "1" : "m";
}

void ModelBuilder::resolve_dofs() {
  model_.n_d = static_cast<Index>(scene_.dofs.size());
  for (size_t i = 0; i < scene_.dofs.size(); ++i) {
    const SceneDof& dof = scene_.dofs[i];
    const bool hinge =
        !dof.element.empty() &&
        std::any_of(scene_.elements.begin(), scene_.elements.end(), [&](const SceneElement& e) {
          return e.name == dof.element && e.kind == Kind::hinge;
        });
    const std::string unit = hinge ? "rad" : coordinate_unit(dof);
    model_.dofs.push_back({dof_name(dof, i), unit, !dof.element.empty(), dof_index_[i]});
  }
}

void ModelBuilder::add_inertia(std::unique_ptr<const Inertia> inertia) {
  auto maps = maps_of(*inertia);
  model_.inertias.push_back({std::move(inertia), std::move(maps)});
}

void ModelBuilder::place_inertias() {
  for (const SceneMass& mass : scene_.masses) {
    const Index node = node_index_.at(mass.node);
    if (mass.mass > 0) add_inertia(std::make_unique<PointMass>(node, mass.mass));
    if (!mass.has_inertia) continue;
    if (scene_.planar) {
      add_inertia(std::make_unique<PlanarBody>(node, mass.inertia(2, 2)));
    } else {
      add_inertia(std::make_unique<Body>(node, mass.inertia));
    }
  }
  for (const SceneElement& element : scene_.elements) {
    if (element.superelement) {
      const SceneSuperelement& body = *element.superelement;
      add_inertia(std::make_unique<SuperelementMass>(superelement(body), body.s, body.M));
      continue;
    }
    const SceneBeam& beam = element.beam;
    if (!is_beam(element) || (beam.mass_per_length == 0 && beam.inertia_per_length == 0)) continue;
    const Index p = node_index_.at(element.node_p), q = node_index_.at(element.node_q);
    const Eigen::Vector3d l_0 = model_.nodes[static_cast<size_t>(q)].position -
                                model_.nodes[static_cast<size_t>(p)].position;
    if (beam.lumped_mass) {
      const Eigen::Vector3d n_x = l_0.normalized();
      for (const Index node : {p, q}) {
        add_inertia(std::make_unique<PointMass>(node, 0.5 * beam.mass_per_length * l_0.norm()));
        if (scene_.planar || beam.inertia_per_length == 0) continue;
        add_inertia(std::make_unique<Body>(
            node, 0.5 * beam.inertia_per_length * l_0.norm() * n_x * n_x.transpose()));
      }
    } else if (scene_.planar) {
      add_inertia(std::make_unique<PlanarBeamMass>(p, q, l_0, beam.mass_per_length));
    } else {
      add_inertia(
          std::make_unique<BeamMass>(p, q, l_0, beam.mass_per_length, beam.inertia_per_length));
    }
  }
}

void ModelBuilder::place_loads() {
  Eigen::VectorXd all = Eigen::VectorXd::Zero(model_.n_x + model_.n_0);
  for (const SceneLoad& load : scene_.loads) {
    const Index index = node_index_.at(load.node);
    const ModelNode& node = model_.nodes[static_cast<size_t>(index)];
    const bool torque = !load.torque.isZero(0);
    if ((torque || load.follows) && !node.has_rotation()) {
      throw InputError(load.place + ": node '" + load.node +
                       "' has no rotation: it takes no torque and turns no force");
    }
    // In space a torque acts on Euler parameters, which change with the rotation.
    const bool turning = load.follows || (torque && !scene_.planar);
    if (turning) {
      model_.turning_loads.push_back({index, load.force, load.torque, load.follows});
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) {
      const auto row = model_.full_translation_row(index, Eigen::Vector3d::Unit(axis));
      all += load.force(axis) * row.transpose();
    }
    if (torque) all(node.rotation.column[0]) += load.torque.z();
  }
  model_.load = all.head(model_.n_x);
  model_.fixed_load = all.tail(model_.n_0);
}

void ModelBuilder::place_operating_point() {
  model_.q_0 = model_.q_dot_0 = Eigen::VectorXd::Zero(model_.n_d);
  for (size_t i = 0; i < scene_.dofs.size(); ++i) {
    model_.q_0(static_cast<Index>(i)) = scene_.dofs[i].value;
    model_.q_dot_0(static_cast<Index>(i)) = scene_.dofs[i].rate;
  }
  model_.q_r_0 = model_.q_r_dot_0 = model_.q_r_ddot_0 = Eigen::VectorXd::Zero(model_.n_r);
  const auto add = [&](const Eigen::VectorXd& pattern, const SceneConstraint& motion) {
    model_.q_r_0 += motion.value * pattern;
    model_.q_r_dot_0 += motion.rate * pattern;
    model_.q_r_ddot_0 += motion.acceleration * pattern;
  };
  for (const SceneConstraint& motion : scene_.prescribed) {
    SceneSignal signal;
    signal.place = motion.place;
    signal.node = motion.node;
    signal.element = motion.element;
    signal.mode = motion.mode;
    if (!motion.element.empty()) add(model_.prescribed_pattern(signal), motion);
    if (motion.rotation) {
      signal.quantity = Quantity::rotation;
      add(model_.prescribed_pattern(signal), motion);
    }
    signal.quantity = Quantity::position;
    for (const auto& direction : motion.directions) {
      signal.direction = direction;
      add(model_.prescribed_pattern(signal), motion);
    }
  }
}

Model make_model(const Scene& scene) {
  if (scene.automatic_dofs) {
    Scene chosen = scene;
    chosen.automatic_dofs = false;
    chosen.dofs = automatic_dofs(scene);
    return make_model(chosen);
  }
  if (scene.dofs.empty()) throw InputError(scene.dofs_place + ": dofs: at least one is needed");
  // What a linear model with its modes takes: 620 MiB were measured for 1800 dofs
  // (docs/accuracy.md). Before the model is built, which takes a while for so many.
  const auto n_d = static_cast<double>(scene.dofs.size());
  require_memory(24 * n_d * n_d,
                 scene.modal_damping ? scene.modal_damping->place : scene.dofs_place,
                 std::to_string(scene.dofs.size()) + " degrees of freedom");
  Model model = ModelBuilder(scene).build();
  check_partition(model, scene.dofs_place);
  if (scene.modal_damping) add_modal_damping(scene, model);
  return model;
}

}  // namespace stillframe
