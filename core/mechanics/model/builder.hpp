#pragma once

#include <map>

#include "core/mechanics/elements/superelement.hpp"
#include "core/mechanics/model/model.hpp"

namespace stillframe {

enum class CoordinateKind { dependent, dynamic, prescribed, fixed, absent };

/// What a scene says of one node's coordinates, before they have numbers. Nodes joined by a hinge
/// share the translation of the first.
struct NodePlan {
  size_t shares = 0;                        ///< the node whose translation this is
  std::vector<Eigen::Vector3d> directions;  ///< claimed ones, in order
  std::vector<CoordinateKind> kinds;
  std::vector<Index> dofs;  ///< index among the scene's dofs, -1 if none
  Index rotation_size = 0;
  std::array<CoordinateKind, 4> rotation_kind{};
  std::array<Index, 4> rotation_dof{-1, -1, -1, -1};
};

/// "x(tip)", "lambda_1(tip)": the name of a dof that is a coordinate of a node, the i-th of them
/// all from 0.
std::string coordinate_name(const SceneDof& dof, size_t i);
std::string coordinate_unit(const SceneDof& dof);

/// Builds a model step by step; make_model calls build().
class ModelBuilder {
 public:
  explicit ModelBuilder(const Scene& scene);
  /// Everything but the check of the partition. Without dofs every coordinate that is neither fixed
  /// nor prescribed becomes dependent.
  Model build();

 private:
  NodePlan& plan(const std::string& node);
  void share_translations();
  void plan_rotations();
  void constrain_rotation(const SceneConstraint& constraint, CoordinateKind kind);
  void claim_rotation_dof(Index i);
  void claim_directions();
  void claim(const std::string& node, const Eigen::Vector3d& direction, CoordinateKind kind,
             Index dof, const std::string& place);
  void make_basis(size_t n);
  void number_coordinates();
  void number_kind(CoordinateKind kind, Index& next);

  void place_elements();
  void place_element(const SceneElement& element);
  Superelement superelement(const SceneSuperelement& body) const;
  void add_element(const std::string& name, std::unique_ptr<const Element> element);
  void number_deformations();
  void resolve_dofs();
  std::string dof_name(const SceneDof& dof, size_t i) const;
  void place_inertias();
  void add_inertia(std::unique_ptr<const Inertia> inertia);
  void place_loads();
  void place_operating_point();
  template <class Part>
  std::vector<PartMap> maps_of(const Part& part) const;

  const Scene& scene_;
  Model model_;
  std::vector<NodePlan> plans_;
  std::map<std::string, Index> node_index_;
  std::vector<Index> dof_index_;
};

}  // namespace stillframe
