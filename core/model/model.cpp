#include "core/model/model.hpp"

#include <algorithm>
#include <cassert>

#include "core/yaml/input_error.hpp"

namespace stillframe {

Index Model::node_index(const std::string& name) const {
  const auto found = std::find_if(nodes.begin(), nodes.end(),
                                  [&](const ModelNode& node) { return node.name == name; });
  assert(found != nodes.end() && "the scene reader has checked every name");
  return found - nodes.begin();
}

Index Model::element_index(const std::string& name) const {
  const auto found = std::find_if(elements.begin(), elements.end(),
                                  [&](const ModelElement& item) { return item.name == name; });
  assert(found != elements.end() && "the scene reader has checked every name");
  return found - elements.begin();
}

Index Model::elastic_row(const std::string& element) const {
  const ModelElement& item = elements[static_cast<size_t>(element_index(element))];
  assert(item.elastic);
  return item.row[0];
}

Eigen::RowVectorXd Model::translation_row(Index node, const Eigen::Vector3d& direction) const {
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(n_x);
  const PartMap& map = nodes[static_cast<size_t>(node)].translation;
  const Eigen::Vector3d local = map.basis.transpose() * direction;
  for (int i = 0; i < 3; ++i) {
    if (map.column[static_cast<size_t>(i)] >= 0) row(map.column[static_cast<size_t>(i)]) = local(i);
  }
  return row;
}

Eigen::VectorXd Model::prescribed_pattern(Index node, const Eigen::Vector3d& direction,
                                          const std::string& place) const {
  const Eigen::RowVectorXd row = translation_row(node, direction);
  const Eigen::VectorXd pattern = row.tail(n_r).transpose();
  // The direction is a unit vector, so what the prescribed coordinates miss of it is compared with
  // 1; 1e-9 is far above the rounding of a basis and far below any angle that a person would write.
  if (std::abs(pattern.norm() - 1.0) > 1e-9) {
    throw InputError(place + ": node '" + nodes[static_cast<size_t>(node)].name +
                     "' is not prescribed along this direction; add it under 'prescribed'");
  }
  return pattern;
}

}  // namespace stillframe
