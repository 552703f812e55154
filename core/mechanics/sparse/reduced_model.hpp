#pragma once

#include <optional>

#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/mechanics/scene/scene.hpp"
#include "core/mechanics/sparse/mixed_model.hpp"
#include "core/mechanics/sparse/reduction_bound.hpp"

namespace stillframe {

/// A model on its lowest modes, and on what forces and prescribed motions do beside them at rest.
struct ReducedModel {
  /// Of the modes, mass-normalised, and then of the corrections: M = I, K + G diagonal.
  LinearModel linear;
  Eigen::Index n_modes = 0, n_corrections = 0;
  double to_hz = 0;              ///< the band that it was asked for
  double first_left_out_hz = 0;  ///< of the lowest mode that is not in it; infinite if all are
  ReductionBound left_out;
  Eigen::Index n_in = 0, n_out = 0;  ///< the bound is of so many first inputs and outputs: of all

  /// What sigma_1(G - G_r) is at most at w, rad/s.
  double bound(double omega) const { return left_out(omega, linear, n_in, n_out); }
};

/// X = psi w + V q: psi is the position that a prescribed motion w leads to at rest, V the lowest
/// modes and, beside them, the static answers to the force inputs and to the inertia and dampers
/// that psi w'' and psi w' pull at. Statically exact, and stress resultants and reactions follow
/// from the balance of forces. Corrections that move no mass follow their forces at once. Source:
/// docs/decisions/0036-reduced-models.md; Craig 1981, chapter 19. Errors: as lowest_modes and
/// mixed_signals.
ReducedModel reduced_model(const MixedModel& mixed, const MixedState& state,
                           const std::vector<SceneSignal>& inputs,
                           const std::vector<SceneSignal>& outputs, const SceneReduction& asked);

}  // namespace stillframe
