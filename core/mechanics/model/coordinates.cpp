// The coordinates of the nodes: which there are, who claims them, and their numbers.
#include "core/errors/input_error.hpp"
#include "core/mechanics/model/builder.hpp"

namespace stillframe {

ModelBuilder::ModelBuilder(const Scene& scene) : scene_(scene), plans_(scene.nodes.size()) {
  for (size_t n = 0; n < scene.nodes.size(); ++n) {
    node_index_[scene.nodes[n].name] = static_cast<Index>(n);
    plans_[n].shares = n;
  }
}

NodePlan& ModelBuilder::plan(const std::string& node) {
  return plans_[static_cast<size_t>(node_index_.at(node))];
}

/// The translation of a hinge's second node is that of its first, also along chains of hinges.
void ModelBuilder::share_translations() {
  for (const SceneElement& element : scene_.elements) {
    if (element.kind != SceneElement::Kind::hinge) continue;
    const size_t kept = plan(element.node_p).shares, gone = plan(element.node_q).shares;
    for (NodePlan& other : plans_) {
      if (other.shares == gone) other.shares = kept;
    }
  }
}

void ModelBuilder::plan_rotations() {
  const Index size = scene_.planar ? 1 : 4;
  for (const SceneElement& element : scene_.elements) {
    if (element.superelement) {
      for (const std::string& node : element.superelement->nodes) plan(node).rotation_size = size;
      continue;
    }
    const bool truss = element.kind == SceneElement::Kind::truss;
    if (!truss || !element.arm_p.isZero(0)) plan(element.node_p).rotation_size = size;
    if (!truss || !element.arm_q.isZero(0)) plan(element.node_q).rotation_size = size;
  }
  for (const SceneMass& mass : scene_.masses) {
    if (mass.has_inertia) plan(mass.node).rotation_size = size;
  }
  for (const SceneConstraint& support : scene_.supports) {
    if (support.rotation) constrain_rotation(support, CoordinateKind::fixed);
  }
  for (const SceneConstraint& motion : scene_.prescribed) {
    if (motion.rotation) constrain_rotation(motion, CoordinateKind::prescribed);
  }
  for (size_t i = 0; i < scene_.dofs.size(); ++i) {
    const SceneDof& dof = scene_.dofs[i];
    if (dof.euler_parameter >= 0 || dof.rotation) claim_rotation_dof(static_cast<Index>(i));
  }
}

void ModelBuilder::constrain_rotation(const SceneConstraint& constraint, CoordinateKind kind) {
  NodePlan& node = plan(constraint.node);
  if (node.rotation_size == 0) {
    throw InputError(constraint.place + ": node '" + constraint.node + "' has no rotation to " +
                     (kind == CoordinateKind::fixed ? "fix" : "prescribe") +
                     ": no beam, no hinge and no inertia is attached to it");
  }
  if (node.rotation_kind[0] != CoordinateKind::dependent) {
    throw InputError(constraint.place + ": node '" + constraint.node +
                     "': its rotation is fixed or prescribed twice");
  }
  node.rotation_kind.fill(kind);
}

void ModelBuilder::claim_rotation_dof(Index i) {
  const SceneDof& dof = scene_.dofs[static_cast<size_t>(i)];
  NodePlan& node = plan(dof.node);
  const auto component = static_cast<size_t>(dof.rotation ? 0 : dof.euler_parameter);
  if (node.rotation_dof[component] >= 0) throw InputError(dof.place + ": this dof is named twice");
  if (node.rotation_size == 0 || node.rotation_kind[component] != CoordinateKind::dependent) {
    throw InputError(dof.place + ": node '" + dof.node + "' has no free rotation");
  }
  node.rotation_kind[component] = CoordinateKind::dynamic;
  node.rotation_dof[component] = i;
}

void ModelBuilder::claim(const std::string& node, const Eigen::Vector3d& direction,
                         CoordinateKind kind, Index dof, const std::string& place) {
  NodePlan& target = plans_[plan(node).shares];
  for (size_t k = 0; k < target.directions.size(); ++k) {
    // Directions are unit vectors written with a few digits; 1e-6 is an error of a micrometre on a
    // metre.
    const double cosine = std::abs(target.directions[k].dot(direction));
    if (cosine > 1 - 1e-6 && kind == CoordinateKind::dynamic && target.dofs[k] >= 0) {
      throw InputError(place + ": this dof is named twice");
    }
    if (cosine > 1e-6) {
      throw InputError(place + ": node '" + node +
                       "': the directions of its supports, prescribed motions and dofs must be "
                       "perpendicular to each other");
    }
  }
  target.directions.push_back(direction);
  target.kinds.push_back(kind);
  target.dofs.push_back(dof);
}

void ModelBuilder::claim_directions() {
  if (scene_.planar) {
    for (size_t n = 0; n < plans_.size(); ++n) {
      if (plans_[n].shares != n) continue;
      claim(scene_.nodes[n].name, Eigen::Vector3d::UnitZ(), CoordinateKind::absent, -1, "");
    }
  }
  for (const SceneConstraint& support : scene_.supports) {
    for (const auto& d : support.directions) {
      claim(support.node, d, CoordinateKind::fixed, -1, support.place);
    }
  }
  for (const SceneConstraint& motion : scene_.prescribed) {
    for (const auto& d : motion.directions) {
      claim(motion.node, d, CoordinateKind::prescribed, -1, motion.place);
    }
  }
  for (size_t i = 0; i < scene_.dofs.size(); ++i) {
    const SceneDof& dof = scene_.dofs[i];
    if (dof.direction) {
      claim(dof.node, *dof.direction, CoordinateKind::dynamic, static_cast<Index>(i), dof.place);
    }
  }
}

/// Completes the claimed directions of a node to an orthonormal basis, the rest dependent.
void ModelBuilder::make_basis(size_t n) {
  NodePlan& target = plans_[n];
  PartMap& map = model_.nodes[n].translation;
  Index count = 0;
  const auto add = [&](Eigen::Vector3d d) {
    for (Index i = 0; i < count; ++i) d -= map.basis.col(i).dot(d) * map.basis.col(i);
    if (d.norm() < 0.5) return false;
    map.basis.col(count++) = d.normalized();
    return true;
  };
  for (const auto& d : target.directions) add(d);
  for (int axis = 0; axis < 3 && count < 3; ++axis) {
    if (add(Eigen::Vector3d::Unit(axis))) {
      target.kinds.push_back(CoordinateKind::dependent);
      target.dofs.push_back(-1);
    }
  }
  map.size = 3;
  map.global_axes = map.basis.isIdentity(0);
}

void ModelBuilder::number_coordinates() {
  for (size_t n = 0; n < plans_.size(); ++n) {
    if (plans_[n].shares == n) make_basis(n);
    model_.nodes[n].rotation.size = plans_[n].rotation_size;
  }
  dof_index_.assign(scene_.dofs.size(), -1);
  Index next = 0;
  number_kind(CoordinateKind::dependent, next);
  model_.n_c = next;
  number_kind(CoordinateKind::dynamic, next);
  model_.n_xd = next - model_.n_c;
  number_kind(CoordinateKind::prescribed, next);
  model_.n_rx = next - model_.n_c - model_.n_xd;
  model_.n_x = next;
  number_kind(CoordinateKind::fixed, next);
  model_.n_0 = next - model_.n_x;
  for (size_t n = 0; n < plans_.size(); ++n) {
    if (plans_[n].shares != n) {
      model_.nodes[n].translation = model_.nodes[plans_[n].shares].translation;
    }
  }
}

void ModelBuilder::number_kind(CoordinateKind kind, Index& next) {
  const auto take = [&](Index& column, Index dof) {
    if (dof >= 0) {
      dof_index_[static_cast<size_t>(dof)] = next;
      model_.dof_of_column.push_back(dof);
    }
    column = next++;
  };
  for (size_t n = 0; n < plans_.size(); ++n) {
    const NodePlan& p = plans_[n];
    ModelNode& node = model_.nodes[n];
    for (size_t i = 0; i < 3 && p.shares == n; ++i) {
      if (p.kinds[i] == kind) take(node.translation.column[i], p.dofs[i]);
    }
    for (size_t i = 0; i < static_cast<size_t>(p.rotation_size); ++i) {
      if (p.rotation_kind[i] == kind) take(node.rotation.column[i], p.rotation_dof[i]);
    }
  }
}

}  // namespace stillframe
