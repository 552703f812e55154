#include <algorithm>
#include <map>

#include "core/elements/beam.hpp"
#include "core/elements/norm_condition.hpp"
#include "core/elements/truss.hpp"
#include "core/model/model.hpp"
#include "core/model/partition.hpp"
#include "core/yaml/input_error.hpp"

namespace stillframe {

namespace {

enum class CoordinateKind { dependent, dynamic, prescribed, fixed };

/// What a scene says of one node's coordinates, before they have numbers.
struct NodePlan {
  std::vector<Eigen::Vector3d> directions;  ///< claimed ones, in order
  std::vector<CoordinateKind> kinds;
  std::vector<Index> dofs;  ///< index among the scene's dofs, -1 if none
  std::array<CoordinateKind, 4> rotation_kind{};
  std::array<Index, 4> rotation_dof{-1, -1, -1, -1};
  bool rotation_fixed = false, has_translation = true, has_rotation = false;
};

class Builder {
 public:
  explicit Builder(const Scene& scene) : scene_(scene), plans_(scene.nodes.size()) {}

  Model build() {
    model_.title = scene_.title;
    for (const SceneNode& node : scene_.nodes) {
      model_.nodes.push_back({node.name, node.position, {}, {}, false});
    }
    plan_rotations();
    claim_directions();
    number_coordinates();
    place_elements();
    resolve_dofs();
    place_masses_and_loads();
    check_partition(model_, scene_.dofs_place);
    return std::move(model_);
  }

 private:
  NodePlan& plan(const std::string& node) {
    return plans_[static_cast<size_t>(model_.node_index(node))];
  }

  void plan_rotations() {
    for (const SceneElement& element : scene_.elements) {
      if (element.kind != SceneElement::Kind::rigid_beam) continue;
      plan(element.node_p).has_rotation = plan(element.node_q).has_rotation = true;
    }
    for (const SceneMass& mass : scene_.masses) {
      if (mass.has_inertia) plan(mass.node).has_rotation = true;
    }
    for (const SceneConstraint& support : scene_.supports) {
      if (!support.rotation) continue;
      NodePlan& node = plan(support.node);
      if (!node.has_rotation) {
        throw InputError(support.place + ": node '" + support.node +
                         "' has no rotation to fix: no beam and no inertia is attached to it");
      }
      node.rotation_fixed = true;
    }
    for (size_t i = 0; i < scene_.dofs.size(); ++i) {
      const SceneDof& dof = scene_.dofs[i];
      if (dof.euler_parameter == 0) continue;
      NodePlan& node = plan(dof.node);
      if (!node.has_rotation || node.rotation_fixed) {
        throw InputError(dof.place + ": node '" + dof.node + "' has no free rotation");
      }
      const auto component = static_cast<size_t>(dof.euler_parameter);
      if (node.rotation_dof[component] >= 0)
        throw InputError(dof.place + ": this dof is named twice");
      node.rotation_kind[component] = CoordinateKind::dynamic;
      node.rotation_dof[component] = static_cast<Index>(i);
    }
  }

  void claim(const std::string& node, const Eigen::Vector3d& direction, CoordinateKind kind,
             Index dof, const std::string& place) {
    NodePlan& target = plan(node);
    for (const Eigen::Vector3d& other : target.directions) {
      // Directions are unit vectors written with a few digits; 1e-6 is an error of a micrometre on
      // a metre.
      if (std::abs(other.dot(direction)) > 1e-6) {
        throw InputError(place + ": node '" + node +
                         "': the directions of its supports, prescribed motions and dofs must be "
                         "perpendicular to each other");
      }
    }
    target.directions.push_back(direction);
    target.kinds.push_back(kind);
    target.dofs.push_back(dof);
  }

  void claim_directions() {
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
  void make_basis(size_t n) {
    NodePlan& target = plans_[n];
    Eigen::Matrix3d& basis = model_.nodes[n].translation.basis;
    Index count = 0;
    const auto add = [&](Eigen::Vector3d d) {
      for (Index i = 0; i < count; ++i) d -= basis.col(i).dot(d) * basis.col(i);
      if (d.norm() < 0.5) return false;
      basis.col(count++) = d.normalized();
      return true;
    };
    for (const auto& d : target.directions) add(d);
    for (int axis = 0; axis < 3 && count < 3; ++axis) {
      if (add(Eigen::Vector3d::Unit(axis))) {
        target.kinds.push_back(CoordinateKind::dependent);
        target.dofs.push_back(-1);
      }
    }
    model_.nodes[n].translation.global_axes = basis.isIdentity(0);
  }

  void number_coordinates() {
    for (size_t n = 0; n < plans_.size(); ++n) {
      make_basis(n);
      if (plans_[n].rotation_fixed) plans_[n].rotation_kind.fill(CoordinateKind::fixed);
      model_.nodes[n].has_rotation = plans_[n].has_rotation;
    }
    dof_index_.assign(scene_.dofs.size(), -1);
    Index next = 0;
    for (const auto kind :
         {CoordinateKind::dependent, CoordinateKind::dynamic, CoordinateKind::prescribed}) {
      const Index first = next;
      for (size_t n = 0; n < plans_.size(); ++n) {
        const NodePlan& p = plans_[n];
        ModelNode& node = model_.nodes[n];
        for (size_t i = 0; i < 3; ++i) {
          if (p.kinds[i] == kind) take(node.translation.column[i], p.dofs[i], next);
        }
        for (size_t i = 0; i < 4 && p.has_rotation; ++i) {
          if (p.rotation_kind[i] == kind) take(node.rotation.column[i], p.rotation_dof[i], next);
        }
      }
      (kind == CoordinateKind::dependent ? model_.n_c
       : kind == CoordinateKind::dynamic ? model_.n_xd
                                         : model_.n_r) = next - first;
    }
    model_.n_x = next;
  }

  void take(Index& column, Index dof, Index& next) {
    column = next++;
    if (dof >= 0) dof_index_[static_cast<size_t>(dof)] = column;
  }

  void place_elements() {
    std::map<std::string, Index>
        dynamic_element;  // the scene's dof that is this element's deformation
    for (size_t i = 0; i < scene_.dofs.size(); ++i) {
      const SceneDof& dof = scene_.dofs[i];
      if (dof.element.empty()) continue;
      if (!dynamic_element.emplace(dof.element, static_cast<Index>(i)).second) {
        throw InputError(dof.place + ": this dof is named twice");
      }
      if (scene_element(dof.element).rigid) {
        throw InputError(dof.place + ": '" + dof.element +
                         "' is rigid, its deformation can be no dof");
      }
    }
    for (size_t n = 0; n < plans_.size(); ++n) {
      if (plans_[n].has_rotation && !plans_[n].rotation_fixed) {
        add_element(model_.nodes[n].name + " (norm)",
                    std::make_unique<NormCondition>(static_cast<Index>(n)), false);
      }
    }
    for (const SceneElement& element : scene_.elements) {
      const Index p = model_.node_index(element.node_p), q = model_.node_index(element.node_q);
      const Eigen::Vector3d l_0 = model_.nodes[static_cast<size_t>(q)].position -
                                  model_.nodes[static_cast<size_t>(p)].position;
      if (element.kind == SceneElement::Kind::truss) {
        add_element(element.name, std::make_unique<Truss>(p, q, l_0), !element.rigid);
      } else {
        add_element(element.name, std::make_unique<Beam>(p, q, l_0), false);
      }
    }
    number_deformations(dynamic_element);
  }

  const SceneElement& scene_element(const std::string& name) const {
    return *std::find_if(scene_.elements.begin(), scene_.elements.end(),
                         [&](const SceneElement& e) { return e.name == name; });
  }

  void add_element(const std::string& name, std::unique_ptr<const Element> element, bool elastic) {
    ModelElement item;
    item.name = name;
    item.elastic = elastic;
    for (const NodePart& part : element->parts()) {
      const ModelNode& node = model_.nodes[static_cast<size_t>(part.node)];
      item.parts.push_back(part.rotation ? node.rotation : node.translation);
    }
    item.element = std::move(element);
    model_.elements.push_back(std::move(item));
  }

  /// Rows: conditions first (zero and dynamic deformations in the order of the elements), redundant
  /// ones last.
  void number_deformations(const std::map<std::string, Index>& dynamic_element) {
    const auto is_condition = [&](const ModelElement& item) {
      return !item.elastic || dynamic_element.contains(item.name);
    };
    Index row = 0;
    for (const bool conditions : {true, false}) {
      const Index first = row;
      for (ModelElement& item : model_.elements) {
        if (is_condition(item) != conditions) continue;
        for (Index i = 0; i < item.element->n_deformations(); ++i) {
          item.row[static_cast<size_t>(i)] = row++;
        }
        const auto dof = dynamic_element.find(item.name);
        if (dof != dynamic_element.end())
          dof_index_[static_cast<size_t>(dof->second)] = item.row[0];
      }
      if (!conditions) model_.n_redundant = row - first;
    }
    model_.n_e = row;
    model_.stiffness = model_.damping = model_.preload = Eigen::VectorXd::Zero(row);
    for (const SceneElement& element : scene_.elements) {
      if (element.rigid) continue;
      const Index r = model_.elastic_row(element.name);
      model_.stiffness(r) = element.stiffness;
      model_.damping(r) = element.damping;
      model_.preload(r) = element.preload;
    }
  }

  void resolve_dofs() {
    model_.n_d = static_cast<Index>(scene_.dofs.size());
    if (model_.n_d == 0) throw InputError(scene_.dofs_place + ": dofs: at least one is needed");
    for (size_t i = 0; i < scene_.dofs.size(); ++i) {
      const SceneDof& dof = scene_.dofs[i];
      Model::Dof resolved{
          .name = {}, .unit = "m", .is_deformation = !dof.element.empty(), .index = dof_index_[i]};
      if (resolved.is_deformation) {
        resolved.name = "e(" + dof.element + ")";
      } else if (dof.direction) {
        resolved.name = "x(" + dof.node + ")" + std::to_string(i + 1);
      } else {
        resolved.name = "lambda_" + std::to_string(dof.euler_parameter) + "(" + dof.node + ")";
        resolved.unit = "1";
      }
      model_.dofs.push_back(resolved);
    }
  }

  void place_masses_and_loads() {
    for (const SceneMass& mass : scene_.masses) {
      model_.masses.push_back(
          {model_.node_index(mass.node), mass.mass, mass.inertia, mass.has_inertia});
    }
    model_.load = Eigen::VectorXd::Zero(model_.n_x);
    for (const SceneLoad& load : scene_.loads) {
      for (int axis = 0; axis < 3; ++axis) {
        model_.load +=
            load.force(axis) *
            model_.translation_row(model_.node_index(load.node), Eigen::Vector3d::Unit(axis))
                .transpose();
      }
    }
  }

  const Scene& scene_;
  Model model_;
  std::vector<NodePlan> plans_;
  std::vector<Index> dof_index_;
};

}  // namespace

Model make_model(const Scene& scene) { return Builder(scene).build(); }

}  // namespace stillframe
