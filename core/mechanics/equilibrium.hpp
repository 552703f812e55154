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

/// Solves f_dd(q^d) = M q''^d by Newton's method, Jacobian -(K + N + G), to rounding: the equilibrium
/// that is reached from the scene as written as loads and prescribed motion grow from zero. They
/// grow in one step, or in as many as Newton's method needs to contract from its start in each.
/// Source: deck, section 9. Errors: Refusal with the load factor that was reached, or with the
/// motion that nothing resists, if no equilibrium is found; Refusal of require_stationary if the
/// motion is not stationary.
Equilibrium solve_equilibrium(const Model& model);

/// The scene with its prescribed values, at rest and without loads, gravity and preloads. Errors:
/// Refusal if there is no such position.
NominalMotion unloaded_position(const Model& model);

/// The largest work of generalised forces (n_d), N m, each over the way of its dof in which a node
/// turns by a radian or goes as far as the scene is large: compares forces and moments in all units
/// and for every choice of dofs.
double largest_work(const Model& model, const Data& data, const Eigen::VectorXd& forces);

/// That of the forces which have to balance at the motion in data: of loads, of stresses and of
/// inertia. The latter as if it had its full lever on a dof: in a straight rotor none has any but
/// rounding. After generalised_forces; completes the accelerations for q''^d. set-up.
double largest_balanced_work(const Model& model, Data& data, const NominalMotion& motion);

/// That of the forces which the rounding of the positions in data makes, with K + N + G (n_d x n_d).
double work_of_rounding(const Model& model, const Data& data, const Eigen::MatrixXd& stiffness);

/// The motion (n_d) that a stiffness (n_d x n_d) resists with a force (n_d): the smallest one, where
/// there are motions that nothing resists.
Eigen::VectorXd motion_against(const Eigen::MatrixXd& stiffness, const Eigen::VectorXd& force);

/// f_dd - M q''^d (n_d): what is out of balance at a motion, from the positions near those in data.
/// False if the position cannot be reached. set-up.
bool out_of_balance(const Model& model, Data& data, const NominalMotion& motion,
                    Eigen::VectorXd& f);

}  // namespace stillframe
