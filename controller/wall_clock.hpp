#pragma once

#include "controller/answer.hpp"
#include "controller/deadlines.hpp"
#include "controller/lcm_io.hpp"
#include "controller/outcome.hpp"

namespace stillframe::controller {

/// Wakes at absolute deadlines on CLOCK_MONOTONIC and answers the newest measurement that is not
/// yet answered, until the run is over. Periods missed whole are skipped and counted late,
/// measurements that were never answered are counted lost; without a new measurement there is no
/// command and the plant holds the last one. Hot: no allocation of its own once the run goes.
/// timeout_s: s without a word from the plant.
Outcome run_wall_clock(LcmIo& io, Answer& answer, Deadlines deadlines, double timeout_s,
                       Counters& counters) noexcept;

}  // namespace stillframe::controller
