#pragma once

#include <string>
#include <vector>

#include "controller/gains.hpp"
#include "controller/policy.hpp"

namespace stillframe::controller {

/// Spectral radius of plant (zero-order hold, exact), law, delay, leak and roll-off as one sampled
/// system, saturation left out.
/// Source: THEORY section 4, fact 3. Set-up. Errors: std::invalid_argument on shapes, Refusal as
/// law_from_gains.
double closed_loop_radius(const Gains& gains);

/// A change to a gains file that gives a stable loop.
struct Remedy {
  std::string change;  ///< as it would be written in the file, "leak_hz: 0.05"
  double radius = 0;   ///< spectral radius with the change
};

/// The changes of one setting that really give a stable loop, or of two settings if no single one
/// does; each is tried numerically, of large loops only the first pairs. Set-up.
std::vector<Remedy> find_remedies(const Gains& gains);

/// Frequencies of the plant's motions that do not decay and that the law does not reach, Hz,
/// upwards: no change of the gains mends them. 0: a motion that nothing holds. Set-up.
std::vector<double> unreached_motions_hz(const Gains& gains);

/// Which those are and what they need, in one line; empty without any. Set-up.
std::string unreached_in_words(const Gains& gains);

/// Why nothing can be said of a loop of this spectral radius: it decays, but more slowly than
/// rounding tells from a drift. Empty of any other.
std::string too_slow_to_tell(const Gains& gains, double radius);

/// The largest spectral radius of the loop while it is ramped in or out: with the law's force taken
/// w times, w = 0.05, 0.10, ... 0.95. A frame that is not stable by itself has one above 1. Set-up.
double ramp_radius(const Gains& gains);

/// That radius if a wall-clock run may ramp. Set-up. Errors: Refusal if it is not below one, or the
/// frame alone is not stable.
double require_stable_ramp(const Gains& gains);

/// By the clock the command of a sample is known at the next. source: whose delay it is. Errors:
/// InputError.
void require_clocked_delay(const Gains& gains, const std::string& source);

/// The force limit of a wall-clock run (N): the lower of the gains file's and the policy's. Set-up.
/// Errors: Refusal if there is none.
double force_limit(const Gains& gains, const Policy& policy);

/// The spectral radius of gains that may be run. Set-up. Errors: Refusal if the loop is not stable,
/// saying the radius, the reason and what mends it.
double require_stable(const Gains& gains);

}  // namespace stillframe::controller
