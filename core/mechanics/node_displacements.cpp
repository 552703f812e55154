#include "core/mechanics/node_displacements.hpp"

#include "core/mechanics/model/local.hpp"
#include "core/mechanics/node_moves.hpp"

namespace stillframe {

std::vector<NodeDisplacement> node_displacements(const Model& model, const Eigen::VectorXd& x) {
  std::vector<NodeDisplacement> all;
  for (const ModelNode& node : model.nodes) {
    NodeDisplacement item{node.name, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                          node.has_rotation()};
    LocalVector local;
    gather({node.translation}, x, local);
    item.displacement = local.head<3>();
    if (node.has_rotation()) {
      gather({node.rotation}, x, local);
      item.rotation = turn_of(local);
    }
    all.push_back(item);
  }
  return all;
}

}  // namespace stillframe
