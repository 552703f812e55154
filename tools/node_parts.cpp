#include "tools/node_parts.hpp"

#include <set>

#include "core/mechanics/elements/rotation.hpp"
#include "core/mechanics/kinematics.hpp"

namespace stillframe::tools {

namespace {

std::set<Index> columns_with_mass(const Model& model) {
  std::set<Index> columns;
  for (const ModelInertia& inertia : model.inertias) {
    for_each_column(inertia.parts, model.n_x, [&](Index, Index column) { columns.insert(column); });
  }
  return columns;
}

/// Rates of rotation over those of the coordinates of a rotation, at their displacement.
Eigen::MatrixXd rates_of_rotation(const LocalVector& local) {
  if (local.size() == 1) return Eigen::Vector3d::UnitZ();
  return 2 * space_rate_matrix(euler_parameters(local).normalized());
}

}  // namespace

NodeParts node_parts(const Model& model, const Eigen::VectorXd& x) {
  std::set<Index> columns = columns_with_mass(model);
  NodeParts parts;
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](const PartMap& map, const Eigen::MatrixXd& rates, const std::string& name) {
    bool moves = false;
    const auto first = static_cast<Index>(parts.names.size());
    const size_t n_entries = entries.size();
    for_each_column({map}, model.n_x, [&](Index i, Index column) {
      for (Index k = 0; k < 3; ++k) entries.emplace_back(first + k, column, rates(k, i));
      // Nodes joined by a hinge share their columns: the first one is named.
      moves = columns.erase(column) > 0 || moves;
    });
    if (!moves) {
      entries.resize(n_entries);
      return;
    }
    for (const char axis : {'x', 'y', 'z'}) parts.names.push_back(name + axis);
  };
  for (const ModelNode& node : model.nodes) {
    add(node.translation, node.translation.basis, node.name + " ");
    if (!node.has_rotation()) continue;
    LocalVector local;
    gather_in_node_axes({node.rotation}, x, local);
    add(node.rotation, rates_of_rotation(local), node.name + " r");
  }
  parts.of_displacements.resize(static_cast<Index>(parts.names.size()), model.n_x);
  parts.of_displacements.setFromTriplets(entries.begin(), entries.end());
  return parts;
}

Eigen::MatrixXd displacements_of_dofs(const Model& model, const Eigen::VectorXd& x) {
  Data data(model);
  data.x = x;
  geometric_transfer_functions(model, data);
  return data.DF;
}

}  // namespace stillframe::tools
