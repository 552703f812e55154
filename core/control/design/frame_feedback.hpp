#pragma once

#include <optional>
#include <vector>

#include "core/control/design/design_model.hpp"
#include "core/control/design/gain_design.hpp"
#include "core/control/mode_responses.hpp"

namespace stillframe {

/// Feedback that is designed in discrete time, on the sampled loop with all that lies between a
/// command and the next measurement.
enum class FeedbackMethod { h2, minimax };

/// A law from the strain forces of m legs to their commands, put together of one for each virtual
/// mode.
struct FrameFeedback {
  Eigen::VectorXd hz;                         ///< r, of the virtual modes, slowest first
  std::vector<std::optional<ModeLaw>> modes;  ///< r; nothing: none that keeps what is asked for
  /// A to D of the frame, without subtract_applied and applied_memory; nothing if a mode has none.
  std::optional<LinearSystem> law;
};

/// With the modes K Phi = M Phi Omega^2, Phi^T M Phi = I of the design model and F_i(z) the law of
/// each by h2_mode_law or minimax_mode_law,
///   u = Q M Phi diag(F_i(z)) Phi^T Q^T e,
/// e (m, N) the strain forces: Phi^T Q^T e are those of the modes, and M Phi turns what is asked of
/// the modes into forces of the legs. With F_i the PI of a mode it is the deck's law (gain_design).
/// targets: one for all, or r. goal: its omega_d and zeta are taken from those. Modes of one
/// frequency and target share a law. Set-up, about a second a mode. Errors: as
/// virtual_modes.
FrameFeedback frame_feedback(const DesignModel& model, const std::vector<ModeTarget>& targets,
                             const Sampling& sampling, double applied_memory, ModeGoal goal,
                             FeedbackMethod method);

}  // namespace stillframe
