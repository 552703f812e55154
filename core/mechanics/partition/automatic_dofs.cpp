#include "core/mechanics/partition/automatic_dofs.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <set>

#include "core/errors/input_error.hpp"
#include "core/mechanics/kinematics.hpp"
#include "core/mechanics/model/local.hpp"
#include "core/mechanics/node_moves.hpp"
#include "core/mechanics/partition/free_model.hpp"
#include "core/mechanics/partition/memory.hpp"
#include "core/mechanics/partition/partition.hpp"

namespace stillframe {

namespace {

/// The columns and rows of D as the choice of dofs compares them: rotations by how far they move
/// what is as far as the scene is large, each condition by its largest part, so that no choice
/// depends on the units or the size of the scene.
void scale(const Model& model, Eigen::MatrixXd& D) {
  const double size = scene_size(model);
  std::set<Index> done;
  for (const ModelNode& node : model.nodes) {
    for_each_column({node.rotation}, D.cols(), [&](Index, Index column) {
      if (done.insert(column).second) D.col(column) /= size;
    });
  }
  for (auto row : D.rowwise()) {
    if (!row.isZero(0)) row /= row.norm();
  }
}

}  // namespace

std::vector<SceneDof> automatic_dofs(const Scene& scene) {
  const Model model = free_model(scene);
  const Index n_conditions = model.n_e - model.n_redundant, n_free = model.n_c;
  std::set<Index> columns;
  for (Index i = 0; i < n_free; ++i) columns.insert(i);
  if (n_conditions > 0) {
    if (n_conditions > n_free) refuse_partition(model, scene.dofs_place);
    // D itself, the block of it and its factors.
    require_memory(static_cast<double>(model.n_e) * static_cast<double>(model.n_x) +
                       2 * static_cast<double>(n_conditions) * static_cast<double>(n_free),
                   scene.dofs_place, std::to_string(n_free) + " coordinates of nodes");
    Eigen::MatrixXd D = dense_jacobian(model).topLeftCorner(n_conditions, n_free);
    scale(model, D);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(D);
    // As in check_partition: rounding leaves 1e-16, a scene written with six digits 1e-6.
    const auto pivots = qr.matrixQR().diagonal().cwiseAbs();
    if (pivots(n_conditions - 1) <= 1e-11 * pivots(0)) refuse_partition(model, scene.dofs_place);
    for (Index i = 0; i < n_conditions; ++i) columns.erase(qr.colsPermutation().indices()(i));
  }
  if (columns.empty()) {
    throw InputError(scene.dofs_place + ": dofs: nothing in the scene can move freely");
  }
  std::vector<SceneDof> dofs;
  for (FreeCoordinate& coordinate : free_coordinates(model, scene.dofs_place)) {
    if (columns.contains(coordinate.column)) dofs.push_back(std::move(coordinate.dof));
  }
  return dofs;
}

}  // namespace stillframe
