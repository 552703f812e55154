#pragma once

#include <optional>

#include "core/control/mode_responses.hpp"
#include "core/numerics/infinity.hpp"

namespace stillframe {

/// The lowest level that a feedback reaches, and what none reaches.
struct MinimaxLaw {
  std::optional<ModeLaw> law;  ///< nothing: none with the goal's margin and bounds
  /// Of no Q of the basis is the level below this, dB, by disk margin and bounds alone: minus
  /// infinity where nothing is excluded.
  double bound_db = -infinity;
};

/// The law of least level with the goal's disk margin, peak and bound above. All stabilising laws
/// are an observer of the mode with x its prediction,
///   u = -K x + Q(z) (e - C_e x),
/// Q stable; T and S - 1/2 are affine in Q. Q is sought among 40 taps and leaky integrals of first
/// and second order with corners from 0.04 targets up, as the one of least
///   max over f of max(|T| / bound, alpha |S - 1/2|, c |1 - 1/z| |F e_u / (1 - F e_u)|),
/// the last for one more sample of delay, c the least of 0.5, 0.75 and 1 with which the loop keeps
/// it (1 is enough, less may do; where 0.5 does not, wider disks are tried as well),
/// by Lawson's weighted least squares: weights times the errors that they leave, whose weighted
/// mean square is a lower bound of the least maximum at every step; the level is what brings it to
/// one, to 0.4 dB. Q is then reduced by balanced truncation, with its output sought anew, as far as
/// the maximum grows by 2 % at most. Source: Youla, Jabr and Bongiorno, IEEE Transactions on
/// Automatic Control 21 (1976) 319-338; Lawson, thesis, University of California 1961; Ellacott and
/// Williams, SIAM Journal on Numerical Analysis 13 (1976) 310-320 (complex). Set-up, about a
/// second. Errors: as solve_riccati.
MinimaxLaw minimax_mode_law(const SampledMode& mode, const ModeGoal& goal);

}  // namespace stillframe
