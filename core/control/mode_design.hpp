#pragma once

#include <optional>

#include "core/control/h2_law.hpp"
#include "core/control/mode_responses.hpp"

namespace stillframe {

/// What the H2 law of a mode weighs.
struct H2Weights {
  double edge_hz = 0;     ///< the floor counts by one over the target up to here
  double noise = 0;       ///< 1, of the sensor over the floor's acceleration: the robustness knob
  double noise_hump = 1;  ///< 1, how much more about three edges
  double effort = 1e-3;   ///< 1, of the force over the acceleration
};

/// The problem behind it, for a mode: w = (floor to be isolated from, white floor, noise),
/// z = (y - target times the first, effort u). The first floor is white behind
///   (s^2 + 2 zeta omega_d s + omega_d^2) / omega_d^2 (s + 4 omega_d) / (s + omega_d / 5)
/// and a Butterworth low-pass of fourth order at the edge; Tustin's rule throughout.
H2Problem h2_problem(const SampledMode& mode, const ModeGoal& goal, const H2Weights& weights);

/// The H2 law of those weights for which the level is least with the goal's disk margin, peak and
/// bound above, stable also with forces of 0.75 and 1.25 times theirs and one more sample of delay:
/// edge, noise and hump are searched for. Nothing if none is found that keeps them all. Set-up,
/// about a second.
std::optional<ModeLaw> h2_mode_law(const SampledMode& mode, const ModeGoal& goal);

/// Whether a law keeps what a goal asks for besides its level.
bool keeps(const SampledMode& mode, const ModeGoal& goal, const ModeResponses& responses,
           const ModeLaw& law);

}  // namespace stillframe
