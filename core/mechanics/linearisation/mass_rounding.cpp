#include "core/mechanics/linearisation/mass_rounding.hpp"

#include <limits>

#include "core/mechanics/node_moves.hpp"

namespace stillframe {

using Eigen::ArrayXd;
using Eigen::VectorXd;

VectorXd mass_rounding(const Model& model, const VectorXd& x, const RowMatrix& X) {
  // Some ten roundings for every element on the way to a node.
  const double eps =
      10 * static_cast<double>(model.elements.size() + 1) * std::numeric_limits<double>::epsilon();
  const Index n = X.cols();
  ArrayXd turn(n), translation(n);
  for (Index i = 0; i < n; ++i) {
    turn(i) = largest_move(model, X.col(i));
    translation(i) = scene_size(model) * turn(i);
  }
  ArrayXd rounding = ArrayXd::Zero(n);
  LocalVector u;
  LocalHessian M;
  for (const ModelInertia& item : model.inertias) {
    gather(item.parts, x, u);
    M.resize(item.inertia->n_local(), item.inertia->n_local());
    item.inertia->mass(u, M);
    std::vector<ArrayXd> moved;
    for (const PartMap& map : item.parts) {
      ArrayXd squares = ArrayXd::Zero(n);
      for_each_column({map}, model.n_x, [&](Index, Index column) {
        squares += X.row(column).transpose().array().square();
      });
      moved.push_back(squares.sqrt());
    }
    Index row = 0;
    for (size_t p = 0; p < item.parts.size(); row += item.parts[p++].size) {
      const ArrayXd& far_p = item.parts[p].size == 3 ? translation : turn;
      Index column = 0;
      for (size_t q = 0; q < item.parts.size(); column += item.parts[q++].size) {
        const ArrayXd& far_q = item.parts[q].size == 3 ? translation : turn;
        const double largest =
            M.block(row, column, item.parts[p].size, item.parts[q].size).cwiseAbs().maxCoeff();
        rounding += eps * largest * (moved[p] * moved[q] + eps * far_p * far_q);
      }
    }
  }
  return rounding;
}

}  // namespace stillframe
