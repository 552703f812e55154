#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "core/control/close_loop.hpp"
#include "core/control/discrete_law.hpp"
#include "core/control/feed_forward.hpp"
#include "core/systems/sampled_plant.hpp"

namespace stillframe {

/// Everything that decides how a loop behaves, from which it can be sampled anew.
struct LoopSettings {
  LoopPlant plant;
  ForceFeedback feedback;  ///< its lead is not asked for: see continuous_law
  LawSampling law;         ///< its sample time and sensor filter are taken from `sampling`
  Sampling sampling;
  FeedForward feed_forward = {};  ///< no part of what is stable, robust or late
  /// A law of one's own, which runs in place of those two, and at its own rate alone; `feedback` is
  /// then what it is held against.
  std::optional<DiscreteLaw> own = {};
};

/// The sampled feedback of a loop, without its feed-forward. Errors: as sample_law.
DiscreteLaw law_of(const LoopSettings& settings);

/// The whole sampled law. Errors: as sample_law and feed_forward_system.
DiscreteLaw whole_law_of(const LoopSettings& settings);

/// Samples by which sampling makes a force late: its delay, half a sample of hold, the lag of the
/// actuators.
double lateness(const Sampling& sampling);

/// The lead that makes up at low frequencies for that and for a roll-off (rad/s; 0: none), in
/// samples.
double matched_lead(const Sampling& sampling, double roll_off);

/// The same loop with another roll-off (rad/s) and the lead that is matched to it.
LoopSettings with_roll_off(LoopSettings settings, double roll_off);

/// The continuous law of a loop. Its lead (s) is what the sampled law's lead is beyond the lateness
/// that it makes up for, 0 if it is less: other settings, another lead.
ForceFeedback continuous_law(const LoopSettings& settings);

/// The closed loop as it is sampled. Errors: as close_loop, sample_and_hold and sample_law.
SampledLoop close_loop(const LoopSettings& settings);

/// What the poles of a loop depend on: its plant without outputs, disturbance and floor
/// integrators.
LoopPlant feedback_part(const LoopPlant& plant);

/// Spectral radius of the closed loop. Errors: as close_loop.
double spectral_radius(const LoopSettings& settings);

/// Sample rates at which the loop is stable, from `lowest_hz` to `highest_hz`, as intervals (Hz);
/// delay, lead and report age are kept in samples. Edges to 1e-6 relative; an interval narrower
/// than the search grid of 30 a decade may be missed.
std::vector<std::pair<double, double>> stable_rates(const LoopSettings& settings, double lowest_hz,
                                                    double highest_hz);

/// The same feedback at another sample rate; delay, lead and report age stay so many samples. A
/// feed-forward is of one rate, and is left out. Errors: std::invalid_argument of a law of one's
/// own, which has one.
LoopSettings at_rate(LoopSettings settings, double rate_hz);

}  // namespace stillframe
