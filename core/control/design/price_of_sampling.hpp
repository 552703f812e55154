#pragma once

#include "core/control/design/control_loop.hpp"
#include "core/control/loop_settings.hpp"

namespace stillframe {

/// Largest excess of the sampled T over the continuous one without roll-off, dB, from a quarter of
/// the target to four times it. Errors: as close_loop.
double price_of_sampling(const ControlLoop& loop, double target_hz, const LoopSettings& settings);

}  // namespace stillframe
