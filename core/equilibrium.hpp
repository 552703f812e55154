#pragma once

#include "core/linearisation.hpp"

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

/// Solves f_dd(q^d) = M q''^d by KINSOL (Newton's method with line search, Jacobian -(K + N + G)),
/// then polishes to rounding. If the direct solution fails, loads and prescribed motion grow in
/// steps from zero, which halve where they fail. Source: deck, section 9. Errors: Refusal with the
/// load factor that was reached, or with the motion that nothing resists, if no equilibrium is
/// found; Refusal of require_stationary if the motion is not stationary.
Equilibrium solve_equilibrium(const Model& model);

/// The scene with its prescribed values, at rest and without loads, gravity and preloads. Errors:
/// Refusal if there is no such position.
NominalMotion unloaded_position(const Model& model);

/// The largest force among those that have to balance at the motion in data: of loads, of stresses
/// and of inertia. The latter as if it had its full lever on a dof: in a straight rotor none has
/// any but rounding. After generalised_forces; completes the accelerations for q''^d. set-up.
double largest_balanced_force(const Model& model, Data& data, const NominalMotion& motion);

/// The largest force that the rounding of the positions in data makes, with K + N + G (n_d x n_d).
double force_of_rounding(const Data& data, const Eigen::MatrixXd& stiffness);

/// f_dd - M q''^d (n_d): what is out of balance at a motion, from the positions near those in data.
/// False if the position cannot be reached. set-up.
bool out_of_balance(const Model& model, Data& data, const NominalMotion& motion,
                    Eigen::VectorXd& f);

}  // namespace stillframe
