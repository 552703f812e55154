#pragma once

#include "controller/answer.hpp"
#include "controller/controller_link.hpp"
#include "controller/outcome.hpp"
#include "stillframe_msgs/timing_t.hpp"

namespace stillframe::controller {

/// Answers every measurement with one command, as fast as the machine goes, until the run is over.
/// A measurement heard again is answered with the same bytes and counted. Hot: no allocation of its
/// own once the run goes. timeout_s: s without a word from the plant.
Outcome run_lock_step(ControllerLink& link, Answer& answer, double timeout_s,
                      stillframe_msgs::timing_t& counters) noexcept;

}  // namespace stillframe::controller
