#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "plant_sim/plant.hpp"
#include "plant_sim/plant_link.hpp"

namespace stillframe {

/// How a run of the plant ended.
struct PlantOutcome {
  bool ended = false;  ///< all samples were made
  std::string reason;  ///< why they were not
};

struct PlantRunOptions {
  double timeout_s = 10;  ///< without a word from the controller, after which the run has failed
  std::int64_t amplifier_hold_samples = 10;  ///< wall-clock: as Amplifier
  double amplifier_fade_s = 1;
  std::function<void(std::int64_t k, std::int64_t n)> progress;  ///< called a few times a second
};

/// Publishes run_info until the controller is ready. Answers an empty text, or why there will be no
/// run.
std::string await_controller(PlantLink& link, double timeout_s);

/// One command for each measurement, as fast as the machine goes: with a delay below one sample the
/// command of sample k is awaited before the plant moves on from k, with a longer one the plant
/// moves while the controller computes, and awaits it then. A measurement that stays unanswered for
/// 200 ms is published again.
PlantOutcome run_lock_step(Plant& plant, PlantLink& link, const PlantRunOptions& options);

/// Sample k at t_0 + k T_s on CLOCK_MONOTONIC, with a delay of one sample or more. The newest
/// command of sample k - 1 or before stands for that of k - 1, and takes effect by its delay; where
/// none came in time the amplifiers hold the last one, and after a while let it go. A plant that is
/// late catches up without skipping any sample. It announces itself again and again, so that a
/// controller may come, or come back, at any time.
PlantOutcome run_wall_clock(Plant& plant, PlantLink& link, const PlantRunOptions& options);

}  // namespace stillframe
