#pragma once

#include "core/mechanics/buckling.hpp"
#include "core/mechanics/sparse/mixed_model.hpp"

namespace stillframe {

/// The n_shapes smallest load multipliers of a mixed model without prescribed displacements, or as
/// many as there are, on its free coordinates (n_d is n_c here): (K + lambda G) v = 0. Errors: as
/// buckling().
Buckling sparse_buckling(const MixedModel& mixed, Eigen::Index n_shapes);

}  // namespace stillframe
