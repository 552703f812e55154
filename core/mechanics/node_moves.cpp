#include "core/mechanics/node_moves.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors/formatted.hpp"
#include "core/mechanics/elements/rotation.hpp"
#include "core/mechanics/model/local.hpp"
#include "core/numerics/worst.hpp"

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

Eigen::Vector3d turn_of(const LocalVector& local) {
  if (local.size() == 1) return {0, 0, local(0)};
  const Vector4 lambda = euler_parameters(local).normalized();
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(lambda(0), lambda(1), lambda(2), lambda(3)));
  return turn.angle() * turn.axis();
}

double scene_size(const Model& model) {
  double size = 0;
  for (const ModelNode& node : model.nodes) {
    size = std::max(size, (node.position - model.nodes.front().position).norm());
  }
  return size > 0 ? size : 1;
}

double scene_size(const Model& model, const Eigen::VectorXd& displacement) {
  const auto place = [&](const ModelNode& node) -> Eigen::Vector3d {
    LocalVector local;
    gather({node.translation}, displacement, local);
    return node.position + local.head<3>();
  };
  double size = scene_size(model);
  const Eigen::Vector3d first = place(model.nodes.front());
  for (const ModelNode& node : model.nodes) size = std::max(size, (place(node) - first).norm());
  return size;
}

double largest_turn(const Model& model, const Eigen::VectorXd& displacement) {
  return largest(model, displacement, 0, 1, 2);
}

double largest_move(const Model& model, const Eigen::VectorXd& displacement) {
  return largest_move(model, displacement, scene_size(model));
}

double largest_move(const Model& model, const Eigen::VectorXd& displacement, double size) {
  return largest(model, displacement, 1 / size, 1, 2);
}

std::string largest_move_in_words(const Model& model, const Eigen::VectorXd& displacement) {
  std::string text;
  double most = 0;
  const auto consider = [&](const ModelNode& node, const Eigen::Vector3d& move, double weight,
                            const char* format) {
    Index axis = 0;
    const double part = weight * move.cwiseAbs().maxCoeff(&axis);
    if (!(part > most)) return;
    most = part;
    text = "node " + node.name + formatted(format, move(axis), "xyz"[axis]);
  };
  for (const ModelNode& node : model.nodes) {
    LocalVector local;
    gather({node.translation}, displacement, local);
    consider(node, local.head<3>(), 1 / scene_size(model), " has moved %.3g m along %c");
    if (!node.has_rotation()) continue;
    gather({node.rotation}, displacement, local);
    consider(node, turn_of(local), 1, " has turned %.3g rad about %c");
  }
  return text;
}

double largest_nodal_work(const Model& model, const Eigen::VectorXd& forces) {
  return largest(model, forces, scene_size(model), 1, 0.5);
}

}  // namespace stillframe
