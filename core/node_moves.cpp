#include "core/node_moves.hpp"

#include <algorithm>
#include <cmath>

#include "core/model/local.hpp"
#include "core/worst.hpp"

namespace stillframe {

namespace {

/// The largest entry of the nodes' translations times a weight, and of their turns times another;
/// those of Euler parameters, half the turn, times twice or half of that.
double largest(const Model& model, const Eigen::VectorXd& x, double translations, double turns,
               double of_parameters) {
  double result = 0;
  const auto gather = [&](const PartMap& map, double weight) {
    for_each_column({map}, model.n_x, [&](Index, Index column) {
      result = worst_of(result, weight * std::abs(x(column)));
    });
  };
  for (const ModelNode& node : model.nodes) {
    if (translations > 0) gather(node.translation, translations);
    gather(node.rotation, node.rotation.size == 4 ? of_parameters * turns : turns);
  }
  return result;
}

}  // namespace

double scene_size(const Model& model) {
  double size = 0;
  for (const ModelNode& node : model.nodes) {
    size = std::max(size, (node.position - model.nodes.front().position).norm());
  }
  return size > 0 ? size : 1;
}

double largest_turn(const Model& model, const Eigen::VectorXd& displacement) {
  return largest(model, displacement, 0, 1, 2);
}

double largest_move(const Model& model, const Eigen::VectorXd& displacement) {
  return largest(model, displacement, 1 / scene_size(model), 1, 2);
}

double largest_nodal_work(const Model& model, const Eigen::VectorXd& forces) {
  return largest(model, forces, scene_size(model), 1, 0.5);
}

}  // namespace stillframe
