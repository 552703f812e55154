#pragma once

#include "core/mechanics/model/model.hpp"

// Between the coordinates of the whole model and those of one element or inertia. "Node axes" are
// the bases in which the model counts translations, "global axes" those in which elements think.
namespace stillframe {

/// Rows contiguous: one coordinate, all its columns.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Calls use(i, column) for every local coordinate i whose column is below n.
template <class Use>
void for_each_column(const std::vector<PartMap>& parts, Index n, const Use& use) noexcept {
  Index at = 0;
  for (const PartMap& map : parts) {
    for (Index i = 0; i < map.size; ++i) {
      const Index column = map.column[static_cast<size_t>(i)];
      if (column >= 0 && column < n) use(at + i, column);
    }
    at += map.size;
  }
}

inline Index local_size(const std::vector<PartMap>& parts) noexcept {
  Index size = 0;
  for (const PartMap& map : parts) size += map.size;
  return size;
}

/// The displacements (or rates) of the parts in node axes; 0 for what x does not hold.
inline void gather_in_node_axes(const std::vector<PartMap>& parts, const Eigen::VectorXd& x,
                                LocalVector& local) noexcept {
  local.setZero(local_size(parts));
  for_each_column(parts, x.size(), [&](Index i, Index column) { local(i) = x(column); });
}

/// The same in global axes.
inline void gather(const std::vector<PartMap>& parts, const Eigen::VectorXd& x,
                   LocalVector& local) noexcept {
  gather_in_node_axes(parts, x, local);
  Index at = 0;
  for (const PartMap& map : parts) {
    if (!map.global_axes) local.segment<3>(at) = (map.basis * local.segment<3>(at)).eval();
    at += map.size;
  }
}

/// Turns the columns of a local matrix, or the entries of a dual vector, from global into node
/// axes.
template <class Matrix>
void columns_to_node_axes(const std::vector<PartMap>& parts, Matrix& local) noexcept {
  Index at = 0;
  for (const PartMap& map : parts) {
    if (!map.global_axes) {
      // A row at a time, whose copy is on the stack: a hot path.
      for (Eigen::Index i = 0; i < local.rows(); ++i) {
        const Eigen::RowVector3d row = local.template block<1, 3>(i, at) * map.basis;
        local.template block<1, 3>(i, at) = row;
      }
    }
    at += map.size;
  }
}
template <class Matrix>
void rows_to_node_axes(const std::vector<PartMap>& parts, Matrix& local) noexcept {
  Index at = 0;
  for (const PartMap& map : parts) {
    if (!map.global_axes) {
      for (Eigen::Index j = 0; j < local.cols(); ++j) {
        const Eigen::Vector3d column = map.basis.transpose() * local.template block<3, 1>(at, j);
        local.template block<3, 1>(at, j) = column;
      }
    }
    at += map.size;
  }
}
/// Both, of a local matrix that is square.
template <class Matrix>
void to_node_axes(const std::vector<PartMap>& parts, Matrix& local) noexcept {
  columns_to_node_axes(parts, local);
  rows_to_node_axes(parts, local);
}

}  // namespace stillframe
