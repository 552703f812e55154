#pragma once

#include <string>

#include "core/mechanics/linearisation/linearisation.hpp"

// What is out of balance at a motion, and beside which forces that is nothing.
namespace stillframe {

/// Rounding leaves some eps of a stiffness of nothing, on a unit diagonal; a soft spring beside a
/// stiff one is 1 there.
inline constexpr double unresisted = 1e-12;

/// The largest generalised force that has to balance at the motion in data, N or N m: of loads, of
/// stresses and of inertia. After generalised_forces; completes the accelerations for q''^d.
/// set-up.
double largest_balanced_force(const Model& model, Data& data, const NominalMotion& motion);

/// The largest work of generalised forces (n_d), N m, each over the way of its dof in which a node
/// turns by a radian or goes as far as the scene is large: compares forces and moments in all units
/// and for every choice of dofs.
double largest_work(const Model& model, const Data& data, const Eigen::VectorXd& forces);

/// That of the forces which have to balance at the motion in data: of loads, of stresses and of
/// inertia. The latter as if it had its full lever on a dof: in a straight rotor none has any but
/// rounding. After generalised_forces; completes the accelerations for q''^d. set-up.
double largest_balanced_work(const Model& model, Data& data, const NominalMotion& motion);

/// That of the forces which the rounding of the positions in data makes, with K + N + G (n_d x
/// n_d).
double work_of_rounding(const Model& model, const Data& data, const Eigen::MatrixXd& stiffness);

/// The motion (n_d) that a stiffness (n_d x n_d) resists with a force (n_d): the smallest one,
/// where there are motions that nothing resists.
Eigen::VectorXd motion_against(const Eigen::MatrixXd& stiffness, const Eigen::VectorXd& force);

/// In how many directions a stiffness (n_d x n_d, of which the symmetric part counts) pushes on
/// what moves, by more than rounding.
Eigen::Index n_negative(const Eigen::MatrixXd& stiffness);

/// The dof with the largest part in a motion that a stiffness (n_d x n_d) does not resist, on a
/// unit diagonal so that metres and radians compare; empty if there is none.
std::string unresisted_dof(const Model& model, const Eigen::MatrixXd& stiffness);

/// f_dd - M q''^d (n_d): what is out of balance at a motion, from the positions near those in data.
/// False if the position cannot be reached. set-up.
bool out_of_balance(const Model& model, Data& data, const NominalMotion& motion,
                    Eigen::VectorXd& f);

}  // namespace stillframe
