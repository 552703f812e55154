#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "controller/controller_link.hpp"
#include "controller/gains.hpp"
#include "controller/outcome.hpp"

namespace stillframe::controller {

/// What the gains and the plant's run_info disagree about, in words; empty if nothing. Set-up.
std::string disagreement(const Gains& gains, const stillframe_msgs::run_info_t& info);

/// What is wrong with the time at which a plant says that its run begins, in words; empty if it is
/// one to wait for, or past. said_ns: by its clock; start_ns: by this host's, on which now_ns is.
/// Set-up.
std::string unsound_start(std::int64_t said_ns, std::int64_t start_ns, std::int64_t now_ns);

/// The end of a handshake: either the run starts, or it is over before it began.
struct Start {
  std::optional<Outcome> over;
  std::int64_t start_ns = 0;        ///< t_0 of a wall-clock run, on the own clock
  std::int64_t start_doubt_ns = 0;  ///< by how much it may be off: 0 but of a plant elsewhere
};

/// Waits for run_info (of run_id, or the first heard), checks it against the gains, answers READY
/// to every repetition, and returns when the plant runs; link follows the run from then on. Set-up.
/// Errors: InputError if run_info and gains disagree, or the run begins at no sound time, after
/// telling the plant FAILED.
Start shake_hands(ControllerLink& link, const Gains& gains, std::optional<std::int64_t> run_id,
                  double timeout_s);

}  // namespace stillframe::controller
