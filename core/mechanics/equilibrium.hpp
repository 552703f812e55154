#pragma once

#include "core/mechanics/linearisation/linearisation.hpp"

namespace stillframe {

/// An equilibrium or stationary motion: the forces of the loads, gravity, preloads and of the
/// prescribed motion of the scene balance, now and as it goes on. q'^d = q''^d = 0 unless positions
/// that a prescribed motion takes along are dofs; then they are what goes along with it.
struct Equilibrium {
  NominalMotion motion;
  double residual = 0;   ///< largest generalised force that is left, N or N m
  double reference = 0;  ///< largest generalised force that had to be balanced, N or N m
  int iterations = 0;    ///< of Newton's method, over all load steps
  int load_steps = 1;    ///< 1: the direct solution converged
};

/// Solves f_dd(q^d) = M q''^d by Newton's method, Jacobian -(K + N + G), to rounding: the
/// equilibrium that is reached from the scene as written as loads and prescribed motion grow from
/// zero. They grow in one step, or in as many as Newton's method needs to contract from its start
/// in each. Source: deck, section 9. Errors: Refusal with the load factor that was reached, or with
/// the motion that nothing resists, if no equilibrium is found; Refusal of require_stationary if
/// the motion is not stationary.
Equilibrium solve_equilibrium(const Model& model);

/// The scene with its prescribed values, at rest and without loads, gravity and preloads. Errors:
/// Refusal if there is no such position.
NominalMotion unloaded_position(const Model& model);

}  // namespace stillframe
