#pragma once

#include "core/mechanics/sparse/mixed_model.hpp"

namespace stillframe {

/// The smallest load multipliers of a mixed model without prescribed displacements, as of Buckling:
/// (K + lambda G) v = 0.
struct SparseBuckling {
  Eigen::VectorXd load_multipliers;  ///< the positive ones, smallest first, n_shapes or fewer
  Eigen::MatrixXd shapes;            ///< n_c x as many, largest entry 1
};

/// Errors: as buckling().
SparseBuckling sparse_buckling(const MixedModel& mixed, Eigen::Index n_shapes);

}  // namespace stillframe
