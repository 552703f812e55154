#pragma once

#include "core/mechanics/modes.hpp"
#include "core/mechanics/sparse/lowest_modes.hpp"

namespace stillframe {

/// The n_modes lowest modes of a mixed model, on its free coordinates (n_d is n_c here), or as many
/// as have mass. eigenvalues p of (M p^2 + D p + K + G) v = 0 are those that the modes without
/// damping turn into, in order and pairs as those of Modes, whichever mode they came from. Without
/// damping they are +-i omega; else those on the modes and on what inverse iteration adds to them,
/// unless all stiffness has one damping time, which changes no mode; NaN, at the end, where that
/// does not converge: of modes that damping keeps from ringing.
/// Errors: as lowest_modes.
Modes sparse_modes(const MixedModel& mixed, const MixedState& state, Eigen::Index n_modes);

}  // namespace stillframe
