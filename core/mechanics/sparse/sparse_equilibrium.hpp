#pragma once

#include "core/mechanics/sparse/lowest_modes.hpp"

namespace stillframe {

struct SparseEquilibrium {
  MixedState state;
  double residual = 0, reference = 0;  ///< as of Equilibrium, of the nodal forces (N, N m)
  int iterations = 0, load_steps = 1;
};

/// Follows the loads, gravity, preloads and prescribed displacements from zero by Newton's method
/// on the mixed form, E^T s = f(x) and e(x) = c s. Errors: as solve_equilibrium.
SparseEquilibrium sparse_equilibrium(const MixedModel& mixed);

}  // namespace stillframe
