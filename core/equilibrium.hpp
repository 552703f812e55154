#pragma once

#include "core/linearisation.hpp"

namespace stillframe {

/// An equilibrium or stationary motion: q'^d = q''^d = 0 under the loads, gravity, preloads and the
/// stationary prescribed motion of the scene.
struct Equilibrium {
  NominalMotion motion;
  double residual = 0;   ///< largest generalised force that is left, N or N m
  double reference = 0;  ///< largest generalised force that had to be balanced, N or N m
  int iterations = 0;    ///< of Newton's method, over all load steps
  int load_steps = 1;    ///< 1: the direct solution converged
};

/// Solves f_dd(q^d) = 0 by KINSOL (Newton's method with line search, Jacobian -(K + N + G)), then
/// polishes to rounding. If the direct solution fails, loads and prescribed motion grow in steps
/// from zero, which halve where they fail. Source: deck, section 9. Errors: Refusal with the load
/// factor that was reached if no equilibrium is found.
Equilibrium solve_equilibrium(const Model& model);

/// The scene's operating point: its equilibrium, or the motion as written with q''^d from the
/// equations of motion. Errors: Refusal if there is no equilibrium, or the motion as written cannot
/// be reached or accelerates a dof without mass.
NominalMotion nominal_motion(const Scene& scene, const Model& model);

}  // namespace stillframe
