#pragma once

#include <string>

#include "core/mechanics/sparse/mixed_model.hpp"

namespace stillframe {

/// The coordinate with the largest part in a motion that E^T c^-1 E + A (n_c x n_c) does not
/// resist, on a unit diagonal so that metres and radians compare; empty if there is none but
/// conditions that are not independent. E: n_rows x n_c, of mixed at some position.
std::string unresisted_coordinate(const MixedModel& mixed, const SparseMatrix& E,
                                  const SparseMatrix& A);

}  // namespace stillframe
