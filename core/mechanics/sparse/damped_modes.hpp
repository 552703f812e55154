#pragma once

#include "core/mechanics/modes.hpp"
#include "core/mechanics/sparse/lowest_modes.hpp"

namespace stillframe {

/// The n_modes lowest modes of a mixed model, on its free coordinates (n_d is n_c here), or as many
/// as have mass. eigenvalues p of (M p^2 + D p + K + G) v = 0 are those that the modes without
/// damping turn into: of each a conjugate pair or two real ones. Without damping they are
/// +-i omega; else from inverse iteration with the damped stiffness at p, the quotient of Rayleigh
/// between, unless all stiffness has one damping time, which changes no mode; NaN where that does
/// not converge, or not to another one than before: of modes that damping keeps from ringing.
/// Errors: as lowest_modes.
Modes sparse_modes(const MixedModel& mixed, const MixedState& state, Eigen::Index n_modes);

}  // namespace stillframe
