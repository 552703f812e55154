#include "core/mechanics/model/model.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/mechanics/scene/quantity.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe {

namespace {

template <class Item>
Index index_of(const std::vector<Item>& items, const char* kind, const std::string& name) {
  const auto found =
      std::find_if(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
  if (found != items.end()) return found - items.begin();
  std::vector<std::string> names;
  for (const Item& item : items) names.push_back(item.name);
  const std::string near = nearest_name(name, names);
  throw std::invalid_argument(std::string("there is no ") + kind + " '" + name + "'" +
                              (near.empty() ? "" : "; the nearest name is '" + near + "'"));
}

}  // namespace

Index Model::node_index(const std::string& name) const { return index_of(nodes, "node", name); }

Index Model::element_index(const std::string& name) const {
  return index_of(elements, "element", name);
}

Index Model::deformation_row(const std::string& element, int mode) const {
  const ModelElement& item = elements[static_cast<size_t>(element_index(element))];
  if (mode < 1 || mode > item.element->n_deformations()) {
    throw std::invalid_argument("deformation " + std::to_string(mode) + " of '" + element +
                                "': allowed are 1 to " +
                                std::to_string(item.element->n_deformations()));
  }
  return item.row[static_cast<size_t>(mode - 1)];
}

std::pair<size_t, Index> Model::owner_of_row(Index row) const {
  for (size_t k = 0; k < elements.size(); ++k) {
    for (Index i = 0; i < elements[k].element->n_deformations(); ++i) {
      if (elements[k].row[static_cast<size_t>(i)] == row) return {k, i};
    }
  }
  throw std::invalid_argument("row " + std::to_string(row) + ": the deformations are 0 to " +
                              std::to_string(n_e - 1));
}

bool Model::is_elastic(Index row) const {
  return row >= n_e - n_redundant || conditions[static_cast<size_t>(row)].dof >= 0;
}

Eigen::RowVectorXd Model::full_translation_row(Index node, const Eigen::Vector3d& direction) const {
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(n_x + n_0);
  const PartMap& map = nodes[static_cast<size_t>(node)].translation;
  const Eigen::Vector3d local = map.basis.transpose() * direction;
  for (int i = 0; i < 3; ++i) {
    const Index column = map.column[static_cast<size_t>(i)];
    if (column >= 0) row(column) = local(i);
  }
  return row;
}

Eigen::RowVectorXd Model::translation_row(Index node, const Eigen::Vector3d& direction) const {
  return full_translation_row(node, direction).head(n_x);
}

Eigen::VectorXd Model::prescribed_pattern(Index node, const Eigen::Vector3d& direction,
                                          const std::string& place) const {
  Eigen::VectorXd pattern = Eigen::VectorXd::Zero(n_r);
  pattern.head(n_rx) = translation_row(node, direction).tail(n_rx).transpose();
  // The direction is a unit vector, so what the prescribed coordinates miss of it is compared with
  // 1; 1e-9 is far above the rounding of a basis and far below any angle that a person would write.
  if (std::abs(pattern.norm() - 1.0) > 1e-9) {
    throw InputError(place + ": node '" + nodes[static_cast<size_t>(node)].name +
                     "' is not prescribed along this direction; add it under 'prescribed'");
  }
  return pattern;
}

Eigen::VectorXd Model::prescribed_pattern(const SceneSignal& input) const {
  Eigen::VectorXd pattern = Eigen::VectorXd::Zero(n_r);
  if (!input.element.empty()) {
    const Index row = deformation_row(input.element, input.mode);
    const auto found = std::find(prescribed_rows.begin(), prescribed_rows.end(), row);
    if (found == prescribed_rows.end()) {
      throw InputError(input.place + ": deformation " + std::to_string(input.mode) + " of '" +
                       input.element + "' is not prescribed; add it under 'prescribed'");
    }
    pattern(n_rx + (found - prescribed_rows.begin())) = 1.0;
    return pattern;
  }
  const Index node = node_index(input.node);
  if (traits_of(input.quantity).of != SignalOf::rotation) {
    return prescribed_pattern(node, input.direction, input.place);
  }
  const Index column = nodes[static_cast<size_t>(node)].rotation.column[0] - (n_x - n_rx);
  if (!planar || column < 0 || column >= n_rx) {
    throw InputError(
        input.place + ": the rotation of node '" + input.node + "' is not prescribed; " +
        (planar ? "add it under 'prescribed'"
                : "in a spatial scene a hinge with a prescribed deformation turns it"));
  }
  pattern(column) = 1.0;
  return pattern;
}

}  // namespace stillframe
